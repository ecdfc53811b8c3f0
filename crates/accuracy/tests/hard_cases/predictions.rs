hard_cases! {
    a_cap_of_a_millionth_of_a_degree,
    a_cap_of_180_degrees,
    von_mises_fisher_of_kappa_1e6,
    prefixes_with_repeated_points,
}
