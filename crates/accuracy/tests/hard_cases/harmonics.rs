hard_cases! {
    colatitudes_down_to_1e_minus_300,
    colatitudes_up_to_pi_minus_1e_minus_300,
    degrees_to_20000_with_orders_near_0,
    degrees_to_20000_with_orders_near_half,
    degrees_to_20000_with_orders_near_the_degree,
    degrees_to_20000_at_zeros_near_a_pole,
    values_under_the_f64_range,
    numbers_over_and_under_the_f64_range,
}
