#![allow(missing_docs, clippy::all)]
use palpate::pivot::*;
use palpate::sensor::Touchpad;
use palpate::shape::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: u64 = args[1].parse().unwrap();
    let first: u64 = args[2].parse().unwrap();
    let noise: f64 = args.get(3).map_or(1.0, |a| a.parse().unwrap());
    let verbose = args.len() > 4;
    let mut used = 0;
    let (mut cert, mut right, mut wrong, mut rc) = (0, 0, 0, 0);
    let mut ratios = vec![];
    let mut times = vec![];
    let (mut inb, mut tot) = (0, 0);
    let mut cov = vec![];
    for seed in first..first + n {
        let shape = random_shape(&RandomShape { mass_offset: 0.2, ..Default::default() }, seed).unwrap();
        let h = |k: u64| {
            let mut x = seed.wrapping_mul(0x9E3779B97F4A7C15) ^ k.wrapping_mul(0xD1B54A32D192ED03);
            x ^= x >> 31;
            x = x.wrapping_mul(0xBF58476D1CE4E5B9);
            x ^= x >> 29;
            (x >> 11) as f64 / (1u64 << 53) as f64
        };
        let friction = 0.3 + 0.5 * h(1);
        let ang = 6.28 * h(2);
        let rho = 0.003 + 0.009 * h(3);
        let tilt = 0.3 * (h(4) - 0.5);
        let strokes: Vec<Stroke> = (0..5)
            .map(|i| {
                let s = if i % 2 == 0 { 1.0 } else { -1.0 };
                let a = 0.5 + 0.05 * (h(10 + i) - 0.5);
                let b = a + s * (0.05 + 0.05 * h(20 + i));
                Stroke { along_m: vec![a, b, b - s * 0.04 * h(30 + i)], press: 2.0 + 4.0 * h(40 + i) }
            })
            .collect();
        let rig = PivotRig::exact(PadPose { base_x_m: 0.01, base_y_m: 0.02, tilt_rad: tilt });
        let o = PivotSimulateOptions {
            rig,
            touchpad: Touchpad { length_m: 1.0, noise_sd_m: 1e-4 * noise, ..Touchpad::ideal() },
            arm_noise_sd_m: 2e-5 * noise,
            center_of_mass_m: [rho * ang.cos(), rho * ang.sin()],
            friction,
            rate_hz: 30.0,
            seed,
            ..Default::default()
        };
        let sim = simulate_strokes(&shape, &strokes, &o).unwrap();
        let along: Vec<f64> =
            sim.log.samples.iter().map(|s| rig.pad.along_and_above(s.pivot_x_m, s.pivot_y_m)[0]).collect();
        let ob = observability(&shape, &sim.theta_rad, &along, &rig, [1e-4 * noise.max(1e-6), 2e-5 * noise.max(1e-6)])
            .unwrap();
        let crb = ob.bound.as_ref().map_or(f64::NAN, |b| b.rms_r_sd_m());
        let tc = {
            let mut f = vec![false; 720];
            for t in sim.theta_rad.iter().flatten() {
                f[((t.rem_euclid(6.283185307) / 6.283185307 * 720.0) as usize).min(719)] = true;
            }
            (0..720).filter(|&i| (0..9).any(|k| f[(i + 720 + k - 4) % 720])).count() as f64 / 720.0
        };
        if tc < 0.3 {
            continue;
        }
        used += 1;
        let nc = sim.theta_rad.iter().flatten().count();
        let t = std::time::Instant::now();
        let r = reconstruct_strokes(&sim.log, &PivotOptions::new(rig));
        let dt = t.elapsed().as_secs_f64();
        times.push(dt);
        match r {
            Err(e) => println!("{seed} error {e}"),
            Ok(r) => {
                let e = compare_strokes(&r, &sim.truth).unwrap();
                let psd: f64 = {
                    let f: Vec<f64> = r.outline.iter().filter(|p| p.touches > 0).map(|p| p.r_sd_m.powi(2)).collect();
                    (f.iter().sum::<f64>() / f.len() as f64).sqrt()
                };
                let ok = e.rms_r_m < (4.0 * psd).max(1e-6 * 0.03) && e.rms_r_m < 4.0 * crb.max(psd).max(1e-8);
                let c = r.is_certified();
                if c {
                    cert += 1
                }
                if ok {
                    right += 1
                }
                if c && !ok {
                    wrong += 1
                }
                if c && ok {
                    rc += 1;
                    if crb.is_finite() {
                        ratios.push(e.rms_r_m / crb);
                    }
                    for p in r.outline.iter().filter(|p| p.touches > 0) {
                        tot += 1;
                        if (p.r_m - shape.radius_m(p.theta_rad - e.rotation_rad)).abs() < 1.96 * p.r_sd_m {
                            inb += 1
                        }
                    }
                }
                cov.push(r.coverage);
                if args.len() > 5 {
                    dump(&r, &sim, &shape);
                }
                if verbose || !c || !ok {
                    println!(
                        "{seed} n {nc} mu {friction:.2} leaps {} seg {} cov {:.2} cert {c} ok {ok} rms {:.2e} psd {:.2e} crb {:.2e} psi {:.4} chi2 {:.2} sd {:.2e} {:.2e} K {} alt {} t {:.0}ms {:?}",
                        sim.leaps.len(),
                        r.segments,
                        r.coverage,
                        e.rms_r_m,
                        psd,
                        crb,
                        e.rms_psi_rad,
                        r.chi2_per_dof,
                        r.sensor_sd_m,
                        r.arm_sd_m,
                        r.shape.harmonics_m().len(),
                        r.alternatives,
                        dt * 1e3,
                        r.doubts
                    );
                }
            }
        }
    }
    let med = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        if v.is_empty() { f64::NAN } else { v[v.len() / 2] }
    };
    let q = ratios.iter().map(|x| x * x).sum::<f64>() / ratios.len() as f64;
    times.sort_by(f64::total_cmp);
    let p95 = times[times.len() * 95 / 100];
    println!(
        "n {used} right {right} cert {cert} right&cert {rc} WRONG {wrong} ratio med {:.2} rms {:.2} band {:.3} time {:.1} ms p95 {:.1} cov med {:.2}",
        med(&mut ratios),
        q.sqrt(),
        inb as f64 / tot as f64,
        1e3 * med(&mut times),
        1e3 * p95,
        med(&mut cov)
    );
}
pub fn dump(r: &PivotReconstruction, sim: &PivotSimulation, shape: &SupportFunction) {
    let nseg = r.segments as u32;
    for i in 0..r.motion.len() {
        if let (Some(a), Some(b)) = (r.motion[i].height_residual_m, r.motion[i].offset_residual_m) {
            if (a / 2e-5).hypot(b / 1e-4) > 5.0 {
                let t = sim.theta_rad[i].unwrap();
                let c = shape.at(t);
                println!(
                    "  BAD {i} seg {:?} true {t:.3} err {:.3} res {:.3} {:.3} r {:.2} d {:.2} kappa {:.2} leap {}",
                    r.motion[i].segment,
                    r.motion[i].psi_rad.unwrap() - sim.truth.motion[i].psi_rad,
                    1e3 * a,
                    1e3 * b,
                    1e3 * c.r,
                    1e3 * c.d,
                    1e3 * (c.r - c.v),
                    sim.leaps.contains(&i)
                );
            }
        }
    }
    for s in 0..nseg {
        let idx: Vec<usize> = (0..r.motion.len()).filter(|&i| r.motion[i].segment == Some(s)).collect();
        let lv: Vec<usize> = sim.leaps.iter().copied().filter(|l| idx.contains(l)).collect();
        println!(" seg {s} samples {}..{} leaps {:?}", idx[0], idx[idx.len() - 1], lv);
        for k in (0..idx.len()).step_by((idx.len() / 12).max(1)) {
            let i = idx[k];
            let t = sim.theta_rad[i].unwrap();
            let c = shape.at(t);
            println!(
                "   {i} true {:.3} found {:.3} err {:.3} r {:.2} d {:.2} kappa {:.2}  res {:.3} {:.3} mm",
                t,
                r.motion[i].theta_rad.unwrap(),
                (r.motion[i].psi_rad.unwrap() - sim.truth.motion[i].psi_rad),
                c.r * 1e3,
                c.d * 1e3,
                (c.r - c.v) * 1e3,
                1e3 * r.motion[i].height_residual_m.unwrap(),
                1e3 * r.motion[i].offset_residual_m.unwrap()
            );
        }
    }
}
