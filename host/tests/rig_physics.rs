use stickslip_host::rig::*;
#[test]
fn probe() {
    for (mu, grip) in [(0.15, 20.0), (0.4, 20.0), (0.4, 30.0)] {
        let setup =
            Setup { description: objects::bench("t"), reality: Reality::ideal(mu, 0.25), step_s: STEP_S };
        for p in
            [Primitive::LinearPush, Primitive::Pivot, Primitive::Roll, Primitive::Lift, Primitive::PlanarPush]
        {
            let mut c = Condition::new(
                p,
                match p {
                    Primitive::Roll => "obj1",
                    Primitive::PlanarPush => "tri",
                    _ => "obj4",
                },
            );
            c.grip_n = if p == Primitive::Roll { 5.0 } else { grip };
            let t = std::time::Instant::now();
            let o = run(&setup, &c, 1, 7).unwrap();
            let e = t.elapsed().as_secs_f64();
            let d = o.exact.last().unwrap().t_s;
            println!("== {p:?} mu {mu} grip {grip}: {d:.2} s, {:.1} x real time", d / e);
            let n = o.exact.len();
            for k in [0, 40, 60, n / 4, n / 2, n * 3 / 4, n - 20, n - 1] {
                let x = &o.exact[k];
                println!(
                    "t {:.2} obj {:.3?} q {:.4?} grp {:.3?} push {:.2?} {:.4?} f1 {:.2?} f2 {:.2?} sup {:.2?}",
                    x.t_s,
                    x.object.0.map(|v| v * 1e3),
                    x.object.1,
                    x.gripper.0.map(|v| v * 1e3),
                    &x.pusher[..3],
                    &x.pusher[3..],
                    x.finger[0],
                    x.finger[1],
                    x.support
                );
            }
        }
    }
}
