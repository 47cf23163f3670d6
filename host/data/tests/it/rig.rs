//! The `[dataset]` part of the mappings of these tests.

/// One prism, disc fingers and a plane that pushes; a literal for `concat!`.
macro_rules! rig {
    () => {
        r#"
[dataset]
name = "lab"
sample_rate_hz = 250.0
gravity_m_s2 = [0.0, 0.0, -9.81]
[[dataset.objects]]
id = "obj4"
shape = "prism"
length_m = 0.1
side_m = 0.025
mass_kg = 0.2
[dataset.fingers]
contact = "disc"
diameter_m = 0.02
[dataset.pushers.linear_push]
contact = "plane"
"#
    };
}
