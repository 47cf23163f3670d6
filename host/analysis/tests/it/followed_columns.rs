//! Broyden's update of a fit's sensitivities.

use stickslip_analysis::fit::engine::follow;
use stickslip_analysis::fit::features::FEATURES;

#[test]
fn followed_columns_tell_the_step_that_was_made_and_what_is_across_it_as_before() {
    let constant = |x: f64| vec![vec![x; FEATURES]];
    let mut columns = vec![constant(2.0), constant(-1.0)];
    let (moved, sizes) = ([0.5, 0.2], [4.0, 25.0]);
    let across = |columns: &[Vec<Vec<f64>>]| {
        // Orthogonal to the step where each parameter counts by its column's size.
        columns[0][0][0] * moved[1] * sizes[1] - columns[1][0][0] * moved[0] * sizes[0]
    };
    let before = across(&columns);
    follow(&mut columns, (&constant(1.0), &constant(4.0)), &moved, (&sizes, 0.0));
    assert!((columns[0][0][7] * moved[0] + columns[1][0][7] * moved[1] - 3.0).abs() < 1e-12);
    assert!((across(&columns) - before).abs() < 1e-12);
    // A prediction that is missing tells nothing.
    let known = columns.clone();
    follow(&mut columns, (&constant(f64::NAN), &constant(4.0)), &moved, (&sizes, 0.0));
    assert_eq!(columns, known);
}
