hard_cases! {
    weights_of_one_point,
    weights_of_repeated_and_antipodal_points,
    weights_of_points_on_a_cap,
    weights_of_as_many_points_as_harmonics,
    spectrum_of_weights_of_mixed_sign_and_scale,
}
