//! Messages have few lines and no control characters, whatever they quote.

use crate::workplace::Workplace;

#[test]
fn values_in_messages_are_escaped_and_short() {
    let place = Workplace::new();
    place.write("esc.csv", "x,y,z\n1,0,\x1b[31mred\x07\n");
    place.write("long.csv", format!("x,y,z\n{}\n", "1 ".repeat(2_000_000)));
    place.write("word.csv", format!("x,y,z\n0,0,{}\n", "z".repeat(3_000_000)));
    place.write("digits.csv", format!("x,y,z\n0,0,{}\n", "9".repeat(400)));
    for (name, part) in
        [("esc.csv", "\\u{1b}[31m"), ("long.csv", ""), ("word.csv", ""), ("digits.csv", "")]
    {
        let outcome = place.run(&format!("spectrum --points {name} --lmax 2"));
        assert_eq!(outcome.status, Some(1), "{name}");
        assert!(outcome.stderr.len() < 2500, "{name}: {} bytes", outcome.stderr.len());
        assert!(outcome.stderr.trim_end().chars().all(|c| !c.is_control()), "{:?}", outcome.stderr);
        assert!(
            outcome.stderr.contains(part) && outcome.stderr.contains(name),
            "{}",
            outcome.stderr
        );
    }
}

#[test]
fn arguments_in_messages_are_escaped_too() {
    let place = Workplace::new();
    for (before, argument, part) in [
        ("sample -n 12", "a\x1b[2Jb", "\\u{1b}[2J"),
        ("sample fibonacci -n 12 -o", "no\x1b[2J/p.csv", "\\u{1b}[2J"),
        ("sample fibonacci -n", "1\n2", "\\n"),
        ("sample", "--no-such=\x07\nsphvar: all is well", "--no-such"),
        ("--json", "no\rsuch", "\\r"),
        ("variance fibonacci -n 12 --integrand", "cap:degrees=1e\x08", "\\u{8}"),
        ("spectrum --points", "no\nsuch.csv", "\\n"),
    ] {
        let mut command = place.command(before);
        let output = command.arg(argument).output().unwrap();
        assert!(!output.status.success(), "{before} {argument:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(part), "{before} {argument:?}: {text}");
        assert!(
            text.chars().all(|c| c == '\n' || !c.is_control()),
            "{before} {argument:?}: {text:?}"
        );
        assert!(!text.lines().any(|line| line.starts_with("sphvar: all is well")), "{text}");
    }
    // A line break in an argument must not end the comment at the head of a file.
    let mut command = place.command("spectrum fibonacci -n 12 --lmax 2 -o");
    let name = "a\nb.csv";
    assert!(command.arg(name).output().unwrap().status.success());
    let text = place.text(name);
    assert!(text.lines().nth(1).unwrap().starts_with("l,"), "{text}");
}

#[test]
fn points_beyond_memory_are_the_reason_given() {
    let place = Workplace::new();
    for command in ["spectrum white-noise", "sample white-noise", "spectrum fibonacci"] {
        place
            .run(&format!("{command} -n 18446744073709551615"))
            .fails(1, &["18446744073709551615 points", "memory"]);
    }
}
