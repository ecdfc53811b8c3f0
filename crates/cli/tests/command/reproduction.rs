//! `sphvar reproduce`: its files, the recovery after a killed run, and the page in a browser.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::workplace::Workplace;

/// A figure of closed forms, and one whose ensembles fall into several pieces.
const FIGURES: &str = "C.1 4.17";

/// Returns every file below a folder with its bytes.
fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(tree(&path));
        } else {
            files.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    files
}

/// Returns the same with names relative to the folder.
fn relative(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let strip =
        |(path, bytes): (PathBuf, Vec<u8>)| (path.strip_prefix(folder).unwrap().to_owned(), bytes);
    tree(folder).into_iter().map(strip).collect()
}

#[test]
#[ignore = "slow"]
fn a_killed_run_resumes_with_the_same_bytes() {
    let place = Workplace::new();
    place.run(&format!("reproduce {FIGURES} --quick -o whole -j 1")).ok();
    let arguments = format!("reproduce {FIGURES} --quick -o out");
    let mut child = place.command(&arguments).stderr(Stdio::null()).spawn().unwrap();
    let pieces = place.path("out/pieces");
    let finished = || {
        let entries = fs::read_dir(&pieces).map(|entries| entries.flatten().collect());
        let entries: Vec<fs::DirEntry> = entries.unwrap_or_default();
        entries.iter().filter(|e| e.path().extension().is_some_and(|x| x == "piece")).count()
    };
    let start = Instant::now();
    while finished() == 0 {
        assert!(start.elapsed() < Duration::from_secs(300), "no piece was ever finished");
        sleep(Duration::from_millis(1));
    }
    // SIGKILL prevents any cleanup.
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!place.path("out/index.html").exists(), "it was killed too late to show anything");
    let kept: BTreeMap<PathBuf, _> = fs::read_dir(&pieces)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().extension().is_some_and(|x| x == "piece"))
        .map(|entry| (entry.path(), entry.metadata().unwrap().modified().unwrap()))
        .collect();
    // The remains of a run that was killed in the middle of a file.
    fs::write(place.path("out/figures/.C.1-a.svg.sphvar-1-0.tmp"), "half").unwrap();
    place.run(&arguments).ok();
    let (whole, resumed) = (relative(&place.path("whole")), relative(&place.path("out")));
    assert_eq!(whole.keys().collect::<Vec<_>>(), resumed.keys().collect::<Vec<_>>());
    for (name, bytes) in &whole {
        assert!(bytes == &resumed[name], "{} differs", name.display());
    }
    for (path, modified) in kept {
        let now = path.metadata().unwrap().modified().unwrap();
        assert_eq!(now, modified, "{} was made again", path.display());
    }
}

#[test]
fn every_panel_has_its_numbers_and_every_claim_its_row() {
    let place = Workplace::new();
    let document = place.run("reproduce C.1 -o out --json").json();
    let files = document["figures"][0]["files"].as_array().unwrap();
    assert_eq!(files.len(), 2 * document["figures"][0]["panels"].as_array().unwrap().len());
    for file in files {
        let text = place.bytes(&format!("out/{}", file.as_str().unwrap()));
        assert!(text.len() > 100, "{file}");
    }
    let claims = document["claims"].as_array().unwrap();
    assert!(!claims.is_empty());
    let table = place.text("out/claims.csv");
    let page = place.text("out/index.html");
    let report = place.text("out/claims.md");
    let options = |claim: &Value| claim["choice"]["options"].as_array().map_or(0, Vec::len);
    let rows: usize = claims.iter().map(|claim| 1 + options(claim)).sum();
    assert_eq!(table.lines().count(), 2 + rows, "{table}");
    for claim in claims {
        let what = claim["what"].as_str().unwrap();
        for text in [&table, &page, &report] {
            assert!(text.contains(what), "{what} is missing");
        }
    }
}

/// Properties of closed forms: 3.1 has rows that are true by construction, two rows of one erratum
/// are in 3.1 and C.1, and verdicts are counted by row but errata by number.
#[test]
fn rows_are_counted_by_verdict_and_errata_once() {
    let place = Workplace::new();
    let document = place.run("reproduce 3.1 C.1 -o out --json").json();
    let claims = document["claims"].as_array().unwrap();
    let with = |verdict: &str| claims.iter().filter(|claim| claim["verdict"] == verdict).count();
    for (verdict, count) in document["verdicts"].as_object().unwrap() {
        assert_eq!(count, with(verdict), "{verdict}");
    }
    assert!(with("by construction") == 2 && with("wrong") == 4, "{document}");
    assert_eq!(document["wrong_errata"], serde_json::json!([1, 33, 37]));
    for name in ["out/claims.md", "out/index.html"] {
        let text = place.text(name);
        let place_of = |part: &str| text.find(part).unwrap_or_else(|| panic!("{name}: no {part}"));
        let parts = [
            "2 more are true by construction",
            "The thesis does not state a choice",
            "What is wrong, and why",
            "7.1, 7.2, C.5-C.12, C.20",
            "Figure 3.1: Real parts",
            "Figure C.1: Energy of the cap",
        ];
        assert!(parts.map(place_of).is_sorted(), "{name}");
        let apart = text.rfind("True by construction").unwrap();
        assert!(apart > place_of("Figure C.1: Energy of the cap"), "{name}");
        // A row that cannot fail appears in its own section only.
        let row = "largest inner product of two different harmonics";
        assert!(text.matches(row).count() == 1 && place_of(row) > apart, "{name}");
    }
}

#[test]
fn wrong_figures_and_busy_folders_are_rejected() {
    let place = Workplace::new();
    place.run("reproduce 4.18 -o out").fails(2, &["unknown figure \"4.18\"", "4.17", "C.1"]);
    assert_eq!(place.names(), Vec::<String>::new());
    place.run("reproduce C.1 -o out --quick --full").fails(2, &["--quick", "--full"]);
    place.write("file", "");
    place.run("reproduce C.1 -o file").fails(1, &["file"]);
    place.run("reproduce C.1 -o out").ok();
    let lock = fs::File::create(place.path("out/.sphvar.lock")).unwrap();
    lock.lock().unwrap();
    place.run("reproduce C.1 -o out").fails(1, &["another run writes to this folder"]);
}

/// The common paths of a browser.
const BROWSERS: [&str; 4] = [
    "/usr/bin/chromium",
    "/usr/bin/chromium-browser",
    "/usr/bin/google-chrome",
    "/snap/bin/chromium",
];

/// The variable that makes a missing browser an error instead of a reason to skip.
const REQUIRED: &str = "SPHVAR_TESTS_NEED_BROWSER";

/// The page in a browser without network: every picture is drawn, no external resource is
/// requested, and no element is wider than the window.
#[test]
fn the_page_needs_nothing_but_itself() {
    let Some(browser) = BROWSERS.iter().find(|path| Path::new(path).exists()) else {
        assert!(std::env::var_os(REQUIRED).is_none(), "no browser: one of {BROWSERS:?} is needed");
        #[expect(clippy::print_stderr, reason = "a skipped test must be visible")]
        {
            eprintln!("skipped: the page was not looked at, for lack of a browser ({BROWSERS:?})");
        }
        return;
    };
    let place = Workplace::new();
    place.run("reproduce C.1 -o out").ok();
    // A script that only the test adds inspects the page.
    let probe = "<script>addEventListener('load', async () => {
        const images = [...document.images];
        images.forEach(image => image.loading = 'eager');
        const drawn = await Promise.all(images.map(
            image => image.decode().then(() => image.naturalWidth > 0, () => false)));
        const requested = performance.getEntriesByType('resource').filter(entry => !entry.name.startsWith('data:'));
        const root = document.documentElement;
        root.dataset.probe = [images.length, drawn.filter(Boolean).length, requested.length,
            root.scrollWidth <= root.clientWidth, document.querySelectorAll('tbody tr').length].join(' ');
    });</script></body>";
    let page = place.text("out/index.html");
    assert!(!page.contains("<script") && !page.contains("http://") && !page.contains("https://"));
    for width in [1400, 400] {
        let name = format!("probed-{width}.html");
        place.write(&name, page.replace("</body>", probe));
        let dom = Command::new(browser)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
            .args(["--disable-background-networking", "--disable-component-update"])
            .args(["--disable-sync", "--disable-quic", "--virtual-time-budget=20000", "--dump-dom"])
            .arg(format!("--window-size={width},900"))
            .arg(format!("--user-data-dir={}", place.path(format!("profile-{width}")).display()))
            .arg(format!("file://{}", place.path(&name).display()))
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let dom = String::from_utf8_lossy(&dom.stdout);
        let answer = dom.split("data-probe=\"").nth(1).and_then(|rest| rest.split('"').next());
        let panels = page.matches("<img ").count();
        let rows = page.matches("<tr><td").count();
        assert!(panels > 0 && rows > 0);
        let expected = format!("{panels} {panels} 0 true {rows}");
        assert_eq!(answer, Some(expected.as_str()), "window of {width}");
    }
}
