hard_cases! {
    triangle_of_1e_minus_12_steradian,
    triangle_of_nearly_2_pi,
    rectangle_seen_edge_on,
    lobe_of_kappa_1e8,
    texel_of_1e20,
    rows_of_zeros,
    map_of_one_column,
    #[ignore = "slow"]
    map_of_16384_x_8192_texels,
    poles_of_every_map,
}
