hard_cases! {
    directions_at_the_poles_at_the_largest_nside,
    directions_at_the_seams_at_the_largest_nside,
    directions_at_the_borders_of_the_caps_at_the_largest_nside,
    centres_at_the_largest_nside,
    numbers_of_both_orders_at_the_largest_nside,
}
