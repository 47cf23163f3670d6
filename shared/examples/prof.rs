use stickslip_shared::predictor::{Predictor, Sample};
use stickslip_shared::selftest;
fn main() {
    let ticks: u32 = std::env::args().nth(1).map_or(3000, |s| s.parse().unwrap());
    let mut hist = std::collections::BTreeMap::<(u32, u32), u32>::new();
    let mut n = 0u32;
    let mut sums = std::collections::BTreeMap::<String, (u32, u32, u32)>::new();
    let mut count = 0;
    selftest::each(2, ticks, 0.1, |p: &mut Predictor<f32>, s: &Sample<f32>| {
        let r = p.tick(s);
        let (scene, model) = p.model();
        let name = format!(
            "{}{}{}{} t{} e{:?}",
            scene.fingers.is_some() as u8,
            scene.pusher.map_or("-", |p| match p {
                stickslip_shared::model::PusherContact::Plane => "P",
                stickslip_shared::model::PusherContact::Line { .. } => "L",
                _ => "T",
            }),
            scene.support.is_some() as u8,
            if matches!(model.base, stickslip_shared::model::Base::Hard) { "H" } else { "S" },
            count / 150,
            model.effects.iter().map(|e| e.code).collect::<Vec<_>>()
        );
        count += 1;
        n += 1;
        let it = u32::from(r.solver_iterations);
        let e = sums.entry(name).or_default();
        e.0 += 1;
        e.1 += it;
        e.2 = e.2.max(it);
        *hist.entry((it / 10, 0)).or_default() += 1;
    });
    for (k, v) in &hist {
        println!("{:?} {v}", k.0 * 10);
    }
    for (k, v) in &sums {
        println!("{k}: mean {:.1} max {}", f64::from(v.1) / f64::from(v.0), v.2);
    }
}
