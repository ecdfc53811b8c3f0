hard_cases! {
    points_within_1e_minus_16_and_repeated,
    all_points_at_a_pole,
    #[ignore = "slow"]
    ten_million_points_in_one_set,
}
