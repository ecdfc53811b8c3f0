hard_cases! {
    fit_of_points_on_a_cap,
    fit_of_as_many_points_as_harmonics,
    fit_of_repeated_points,
    fit_of_noise_of_1e6,
}
