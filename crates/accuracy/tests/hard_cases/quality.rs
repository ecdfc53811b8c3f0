hard_cases! {
    riesz_energies_of_clusters_and_close_pairs,
    measures_of_one_point,
    measures_of_two_points,
    measures_of_repeated_and_antipodal_points,
    measures_with_weights_of_mixed_sign_and_scale,
    measures_of_points_1e_minus_7_apart,
    measures_of_a_million_points_at_a_pole,
}
