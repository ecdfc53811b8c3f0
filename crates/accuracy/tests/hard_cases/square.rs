use sphvar_accuracy::{Area, Effort, trials};

hard_cases! {
    one_point_on_the_square,
    coordinates_at_0_and_1_minus_an_ulp,
    million_equal_points_on_the_square,
    regular_grid_at_its_multiples,
    kmax_0_on_the_square,
    weights_of_any_sign_and_scale_on_the_square,
}

#[test]
fn errors_of_quick_trials_are_within_their_bounds() {
    for mut trial in trials(Area::Square, Effort::Quick) {
        trial.subject.run();
        let errors = trial.subject.errors();
        assert!(errors.count() > 0 && errors.max() <= trial.bound, "{trial:?}: {:e}", errors.max());
        // A method whose error is far below its bound wastes time, or the comparison is void.
        assert!(errors.max() >= 1e-3 * trial.bound, "{trial:?}: {:e}", errors.max());
    }
}
