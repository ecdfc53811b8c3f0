//! `sphvar rotations`.

use crate::workplace::Workplace;

/// The last lines name the sampler of the least error at each N, and compare it with the mean error
/// of independent uniform rotations, which is exact: 100 sets have a mean square with a relative
/// standard deviation below 15 %, so that 50 % fails for fewer than 1e-3 of seeds.
#[test]
fn errors_are_compared_with_those_of_uniform_rotations() {
    let place = Workplace::new();
    let arguments = "rotations uniform,super-fibonacci -n 20,150 --kappa 3 -m 100";
    let json = place.run(&format!("{arguments} --json")).ok().json();
    let rows = json["rows"].as_array().unwrap();
    for row in rows {
        let [n, error, of_uniform] =
            ["n", "error", "error_of_uniform"].map(|key| row[key].as_f64().unwrap());
        assert!(of_uniform > 0.0, "{row}");
        if row["sampler"] == "uniform" {
            let ratio = (error / of_uniform).powi(2);
            assert!((ratio - 1.0).abs() < 0.5, "{n}: {ratio}");
            assert!(row["error_stderr"].as_f64().unwrap() < 0.2 * error, "{row}");
        } else {
            assert!(row["error_stderr"].is_null() && error < of_uniform, "{row}");
        }
    }
    let text = place.run(arguments).ok().stdout;
    for n in [20, 150] {
        let expected = format!("N = {n}: the least error is that of super-fibonacci, ");
        assert!(text.contains(&expected), "{text}");
    }
    assert!(text.starts_with("sampler"), "{text}");
    // A constant has no error.
    let text = place.run("rotations super-fibonacci -n 20 --kappa 0").ok().stdout;
    assert!(!text.contains("least error"), "{text}");
}

/// Powers of degrees that are exact are 0, not rounding errors.
#[test]
fn exact_degrees_have_no_power() {
    let place = Workplace::new();
    let json = place.run("rotations healpix-hopf -n 72 --json").ok().json();
    let row = &json["rows"][0];
    let exact = row["exact_degree"].as_u64().unwrap();
    assert!(exact >= 1, "{row}");
    for l in (1..=4_usize).take_while(|l| *l as u64 <= exact) {
        assert_eq!(row["power"][l], 0.0, "{row}");
    }
}

#[test]
fn weights_are_written_to_archives() {
    let place = Workplace::new();
    let arguments = "rotations sukharev:weights=cell -n 40 -m 3 --format matrices";
    place.run(&format!("{arguments} -o q.npy")).fails(2, &["q.npy", "no weights", ".npz"]);
    place.run(&format!("{arguments} -o q.npz")).ok();
    let mut archive =
        zip::ZipArchive::new(std::fs::File::open(place.path("q.npz")).unwrap()).unwrap();
    let mut shape = |name: &str| {
        let array = npyz::NpyFile::new(archive.by_name(name).unwrap()).unwrap();
        let shape = array.shape().to_vec();
        (shape, array.into_vec::<f64>().unwrap())
    };
    let (rotations, weights) = (shape("rotations.npy"), shape("weights.npy"));
    assert_eq!((rotations.0, weights.0), (vec![3, 40, 3, 3], vec![3, 40]));
    assert!(weights.1.iter().any(|w| (w / weights.1[0] - 1.0).abs() > 0.01));
    // Rows of matrices are unit vectors.
    let lengths = rotations.1.chunks(3).map(|row| row.iter().map(|x| x * x).sum::<f64>());
    assert!(lengths.into_iter().all(|length| (length - 1.0).abs() < 1e-12));
}

#[test]
fn errors_say_what_would_be_right() {
    let place = Workplace::new();
    place
        .run("rotations healpix-hopf -n 500")
        .fails(2, &["72 nside^3", "--nearest", "order=layered takes any number"]);
    place
        .run("rotations uniform -n 5 --kappa -1.5")
        .fails(2, &["--kappa must be from 0 to 3000, got -1.5"]);
}

/// Long measures are announced; short ones are not.
#[test]
fn long_measures_are_announced() {
    let place = Workplace::new();
    let short = place.run("rotations uniform -n 50").ok();
    assert!(!short.stderr.contains("take about"), "{}", short.stderr);
}
