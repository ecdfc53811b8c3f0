hard_cases! {
    power_of_1e_minus_20_at_epsilon_1e_minus_6,
    power_of_1e_minus_20_at_epsilon_1e_minus_9,
    power_of_1e_minus_20_at_epsilon_1e_minus_12,
    power_of_1e_minus_20_by_the_exact_transform,
    realizations_merged_in_any_order,
    catalogues_in_blocks,
}
