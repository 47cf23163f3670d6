use stickslip_host::lcp_files::*;
use stickslip_shared::lcp::{dense::Dense, *};
fn main() {
    let mut d = Box::new(Dense::<f64, 128>::new());
    let (mut bad, mut total) = (0, 0);
    for f in std::env::args().skip(1) {
        let p = read(f.as_ref()).unwrap();
        let list = match p {
            ProblemFile::Dense(s) => s.problems,
            ProblemFile::Factors(s) => s.problems.iter().map(|f| f.dense()).collect(),
        };
        let mut times = vec![];
        let mut worst = 0.0f64;
        let mut piv = vec![];
        let mut paths = vec![];
        let mut ok = 0;
        for (m, q) in &list {
            let t = std::time::Instant::now();
            let o = d.solve(m, q);
            times.push(t.elapsed().as_secs_f64() * 1e6);
            let r = o.report();
            worst = worst.max(r.residual);
            piv.push(r.pivots);
            total += 1;
            if r.status == Status::Solved {
                ok += 1
            } else {
                bad += 1;
                println!("   {:?}", r)
            }
            paths.push(match r.path {
                Path::Restarted(k) => k,
                _ => 0,
            });
        }
        times.sort_by(f64::total_cmp);
        println!(
            "{:30} ok {}/{} worst {:.1e} med {:.0}us max {:.0}us piv {:?} paths {:?}",
            f.rsplit('/').next().unwrap(),
            ok,
            list.len(),
            worst,
            times[times.len() / 2],
            times[times.len() - 1],
            &piv[..6.min(piv.len())],
            &paths[..6.min(piv.len())]
        );
    }
    println!("bad {bad}/{total}");
}
