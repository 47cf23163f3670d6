//! Forces that swing about a line.

use stickslip_analysis::diagnose::swing::about_line;

#[test]
fn a_line_does_not_swing_and_a_sine_by_half_its_squared_amplitude() {
    let line: Vec<f64> = (0..100).map(|i| 3.0 - 0.2 * f64::from(i)).collect();
    assert!(about_line(&line) < 1e-18);
    let sine = |i: i32| 2.0 * (f64::from(i) * std::f64::consts::TAU / 10.0).sin();
    let y: Vec<f64> = (0..1000).map(|i| 5.0 + 0.01 * f64::from(i) + sine(i)).collect();
    assert!((about_line(&y) / 1000.0 - 2.0).abs() < 1e-2);
}
