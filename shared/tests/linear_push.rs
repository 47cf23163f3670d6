//! The paper's linear push against figures known from elsewhere.

use nalgebra::UnitQuaternion;
use stickslip_shared::cone::ConeStatus;
use stickslip_shared::contact::SLOTS;
use stickslip_shared::model::*;
use stickslip_shared::real::{Real, Vec3};
use stickslip_shared::shape::inertia;
use stickslip_shared::step::{Drive, Moving, State, StepOutput, step};

fn scene<R: Real>() -> Scene<R> {
    let shape = Shape::Prism { length_m: R::of(0.1), side_m: R::of(0.025) };
    let mass_kg = R::of(0.2005);
    Scene {
        gravity_m_s2: [R::zero(), R::zero(), R::of(-9.81)],
        object: Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg },
        fingers: Some(FingerContact::Disc { diameter_m: R::of(0.02) }),
        pusher: Some(PusherContact::Plane),
        support: None,
    }
}

fn model<R: Real>(mu: f64, mu_pusher: f64) -> Model<R> {
    Model::base(Base::Hard, Friction { finger: R::of(mu), pusher: R::of(mu_pusher), support: R::of(0.3) })
}

/// Pushes towards -X against a fixed plane; returns the state at the end and the push force
/// after 1 s.
fn push<R: Real>(
    model: &Model<R>,
    grip_n: f64,
    speed_m_s: f64,
    seconds: f64,
    mut each: impl FnMut(&State<R, SLOTS>, &StepOutput<R, SLOTS>),
) -> State<R, SLOTS> {
    let scene = scene::<R>();
    let dt = R::of(0.004);
    let gap = R::of(0.0005);
    let mut drive = Drive {
        dt_s: dt,
        carrier: UnitQuaternion::identity(),
        carrier_m_s: Vec3::new(R::of(-speed_m_s), R::zero(), R::zero()),
        carrier_rad_s: Vec3::zeros(),
        pusher: Some(Moving {
            position_m: Vec3::new(R::of(-0.05) - gap, R::zero(), R::zero()),
            rotation: UnitQuaternion::identity(),
            velocity_m_s: Vec3::new(R::of(speed_m_s), R::zero(), R::zero()),
            angular_rad_s: Vec3::zeros(),
            reference_m: Vec3::new(R::of(-0.05) - gap, R::zero(), R::zero()),
        }),
        support: None,
        grip_n: R::of(grip_n),
        trial: R::zero(),
    };
    let mut state = State::held(&scene, model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    for _ in 0..(seconds / 0.004) as usize {
        let out = step(&scene, model, &mut state, &drive);
        each(&state, &out);
        if let Some(p) = &mut drive.pusher {
            p.position_m += p.velocity_m_s * dt;
            p.reference_m = p.position_m;
        }
    }
    state
}

#[test]
fn report() {
    for mu in [0.15, 0.4] {
        let mut n = 0;
        let (mut its, mut worst) = (0, 0);
        let t = std::time::Instant::now();
        let end = push::<f64>(&model(mu, 0.25), 20.0, 0.010, 1.5, |s, o| {
            n += 1;
            its += o.iterations;
            worst = worst.max(o.iterations);
            if n % 25 == 1 {
                println!(
                    "{:.3} {:?} it {} x {:.3} z {:.4} push {:.3} fz {:.3} util {:.3} {:.3} n {:?} res {:.1e}",
                    s.time_s,
                    o.status,
                    o.iterations,
                    s.position_m.x * 1e3,
                    s.position_m.z * 1e3,
                    o.reading.pusher[0],
                    o.reading.pusher[2],
                    o.utilisation[0],
                    o.utilisation[1],
                    o.normal_n.map(|x| (x * 100.0).round() / 100.0),
                    o.residual_n
                );
            }
        });
        println!(
            "mu {mu}: sag {:.3} mm, mean it {:.2}, worst {worst}, {:.2} us/step",
            -end.position_m.z * 1e3,
            its as f64 / n as f64,
            t.elapsed().as_secs_f64() * 1e6 / n as f64
        );
        let end32 = push::<f32>(&model(mu, 0.25), 20.0, 0.010, 1.5, |_, o| {
            worst = worst.max(o.iterations);
            if o.status != ConeStatus::Solved {
                println!("{:?} {}", o.status, o.residual_n)
            }
        });
        println!("f32: sag {:.4}, worst {worst}", -end32.position_m.z * 1e3);
    }
}
