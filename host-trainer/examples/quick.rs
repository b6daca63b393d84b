use ballrace::sindy_nn::{engine::Samples, gradient::Lambdas, layout::Layout, train::*};
use ballrace_core::library::Library;
use ballrace_core::states::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    let a: Vec<f32> = text.lines().map(|l| l.split([',', ';']).nth(5).unwrap().parse().unwrap()).collect();
    let spec = StateSpec {
        dimension: 8,
        orders: Orders::Even,
        alignment: if std::env::args().nth(2).as_deref() == Some("forward") {
            Alignment::Forward
        } else {
            Alignment::Half
        },
    };
    let mut delays = vec![0.0; spec.delay_len()];
    let mut vs = VirtualStates::new(spec, &mut delays).unwrap();
    let (mut x, mut dx) = ([0.0; 8], [0.0; 8]);
    let mut s = Samples { inputs: 8, x: vec![], dx: vec![] };
    for v in a {
        if vs.push(v, &mut x, &mut dx) {
            s.x.extend(x);
            s.dx.extend(dx);
        }
    }
    for d in [&mut s.x, &mut s.dx] {
        for i in 0..8 {
            let n = d.len() / 8;
            let m = d.iter().skip(i).step_by(8).sum::<f32>() / n as f32;
            let v = (d.iter().skip(i).step_by(8).map(|v| (v - m) * (v - m)).sum::<f32>() / n as f32).sqrt();
            d.iter_mut().skip(i).step_by(8).for_each(|x| *x = (*x - m) / v);
        }
    }
    let layout = Layout::new(&[8, 256, 8], &[8, 256, 8], Library::new(8, 2, 2).unwrap()).unwrap();
    let macs = layout.multiply_adds();
    let n = s.len();
    let config = TrainConfig { threshold: 0.0, patience: 0, ..TrainConfig::default() };
    for threads in [1, 2, 2, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let t = std::time::Instant::now();
            let r = train(&layout, &s, &Samples::default(), &config, &mut |_| ());
            let e = t.elapsed().as_secs_f64();
            println!(
                "{threads} threads {e:.3} s, {} steps, loss {:.5}, {:.1} GMAC/s, macs {macs}",
                r.steps,
                r.last_batch.total(Lambdas::PAPER),
                macs as f64 * n as f64 * 500.0 / e / 1e9
            );
        });
    }
}
