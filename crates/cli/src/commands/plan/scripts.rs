//! The scripts of a plan. All paths in them are absolute and quoted for a shell.

use super::manifest::{Engine, LOGS, Manifest, PARTS};
use super::words::PlannedWords;
use crate::message;
use crate::report::quoted;

/// The script of one part.
pub(super) const PART: &str = "part";
/// The script of the merge.
pub(super) const MERGE: &str = "merge";
/// The script that starts everything, of the engines but Dask.
pub(super) const SUBMIT: &str = "submit";
/// The script for the Python package of an engine.
pub(super) const RUN: &str = "run.py";
/// The job file of HyperQueue, which `submit` writes.
const JOB: &str = "job.toml";
const SLURM_PARTS: &str = "array.sbatch";
const SLURM_MERGE: &str = "merge.sbatch";

/// Checks that `parts` is a list of parts such as `3,7-9`, none of them greater than `count`, and
/// defines `numbers`, which prints them one a line.
const NUMBERS: &str = r#"usage() {
    echo "$1; usage: sh $dir/submit [PARTS], from 1 to $count such as 1 or 1-$count" >&2
    exit 2
}
case $parts in
'' | *[!0-9,-]* | *- | *-,* | *, | *,,*)
    usage "expected a list of parts, got \"$parts\""
    ;;
esac
are_parts() {
    printf '%s\n' "$parts" | tr , '\n' | while IFS=- read -r first last; do
        last=${last:-$first}
        case $first:$last in
        *[!0-9:]* | :* | 0* | *:0*) exit 1 ;;
        esac
        if ! { [ "$first" -le "$last" ] && [ "$last" -le "$count" ]; } 2>/dev/null; then
            exit 1
        fi
    done
}
if ! are_parts; then
    usage "expected parts from 1 to $count, got \"$parts\""
fi
numbers() {
    printf '%s\n' "$parts" | tr , '\n' | while IFS=- read -r first last; do
        last=${last:-$first}
        while [ "$first" -le "$last" ]; do
            echo "$first"
            first=$((first + 1))
        done
    done
}
"#;

/// Returns the scripts of a plan in `folder`, an absolute path, with their names.
pub(super) fn scripts(
    manifest: &Manifest,
    words: &PlannedWords,
    folder: &str,
) -> Vec<(&'static str, String)> {
    let mut scripts =
        vec![(PART, part(manifest, words, folder)), (MERGE, merge(manifest, words, folder))];
    match manifest.engine {
        Engine::Shell => scripts.push((SUBMIT, shell_submit(manifest, folder))),
        Engine::Slurm => {
            scripts.push((SLURM_PARTS, slurm_job(manifest, folder, true)));
            scripts.push((SLURM_MERGE, slurm_job(manifest, folder, false)));
            scripts.push((SUBMIT, slurm_submit(manifest, folder)));
        }
        Engine::Hyperqueue => {
            scripts.push((SUBMIT, hyperqueue_submit(manifest, folder)));
            scripts.push((RUN, include_str!("scripts/hyperqueue.py").to_owned()));
        }
        Engine::Dask => scripts.push((RUN, include_str!("scripts/dask.py").to_owned())),
    }
    scripts
}

/// Returns the lines that define the folders and the program.
fn head(manifest: &Manifest, folder: &str) -> String {
    format!(
        "dir={}
if [ -z \"${{SPHVAR:-}}\" ]; then
    SPHVAR={}
fi
",
        quoted(folder),
        quoted(&manifest.program)
    )
}

/// Returns a text as lines of a comment.
fn comment(text: &str) -> String {
    format!("# {}\n", message::escape(text))
}

fn part(manifest: &Manifest, words: &PlannedWords, folder: &str) -> String {
    let own = format!(
        "--shard \"$part/{}\" --save \"$dir/{PARTS}/$name.shard\" --wait --log \"$dir/{LOGS}/$name.jsonl\"",
        manifest.parts
    );
    let command: Vec<String> = words.with_own(&own, manifest.threads);
    format!(
        "#!/bin/sh
# Computes one part: sh part NUMBER. What it prints is added to {LOGS}/NUMBER.out. A part that is done takes no
# time, and interrupted work is continued. SPHVAR names another program than the one that made this plan.
{}set -eu
count={}
part=${{1:-}}
usage() {{
    echo \"$1; usage: sh $0 NUMBER, from 1 to $count\" >&2
    exit 2
}}
case $part in
'') usage \"missing the number of the part\" ;;
0* | *[!0-9]*) usage \"expected the number of a part, got \\\"$part\\\"\" ;;
esac
if ! [ \"$part\" -le \"$count\" ] 2>/dev/null; then
    usage \"there is no part $part\"
fi
{}name=$(printf %0{}d \"$part\")
exec >>\"$dir/{LOGS}/$name.out\" 2>&1
cd {}
exec \"$SPHVAR\" {}
",
        comment(&manifest.line()),
        manifest.parts,
        head(manifest, folder),
        manifest.digits,
        quoted(&manifest.folder),
        command.join(" ")
    )
}

fn merge(manifest: &Manifest, words: &PlannedWords, folder: &str) -> String {
    let form = if words.is_json { " --json" } else { "" };
    let quiet = if words.is_quiet { " --quiet" } else { "" };
    format!(
        "#!/bin/sh
# Merges the parts and writes what the command writes.
{}set -eu
{}cd {}
exec \"$SPHVAR\" merge{form}{quiet} --log \"$dir/{LOGS}/merge.jsonl\" \"$dir\"
",
        comment(&manifest.line()),
        head(manifest, folder),
        quoted(&manifest.folder),
    )
}

/// Returns the beginning of the script that starts everything.
fn submit_head(manifest: &Manifest, folder: &str, about: &str) -> String {
    format!(
        "#!/bin/sh
# {about}: sh submit [PARTS], such as 3,7-9 (default: all).
{}set -eu
dir={}
count={}
parts=${{1-1-$count}}
{NUMBERS}",
        comment(&manifest.line()),
        quoted(folder),
        manifest.parts
    )
}

fn shell_submit(manifest: &Manifest, folder: &str) -> String {
    let workers = match manifest.workers {
        Some(workers) => format!("workers={workers}\n"),
        None => format!(
            "workers=$(($(getconf _NPROCESSORS_ONLN) / {}))
if [ \"$workers\" -lt 1 ]; then
    workers=1
fi
",
            manifest.threads.max(1)
        ),
    };
    let workers = if manifest.threads == 0 && manifest.workers.is_none() {
        "# A part uses all cores.\nworkers=1\n".to_owned()
    } else {
        workers
    };
    format!(
        "{}{workers}if ! numbers | xargs -n 1 -P \"$workers\" sh -c 'sh \"$0/{PART}\" \"$1\" || exit 1' \"$dir\"; then
    echo \"parts failed; see: sphvar plan status $dir\" >&2
    exit 1
fi
exec sh \"$dir/{MERGE}\"
",
        submit_head(manifest, folder, "Runs parts on this machine, then the merge"),
    )
}

fn slurm_job(manifest: &Manifest, folder: &str, is_array: bool) -> String {
    let mut options =
        vec![format!("--job-name=sphvar-{}", if is_array { "parts" } else { "merge" })];
    if is_array {
        options.push(format!("--array=1-{}", manifest.parts));
        // The script of a part redirects its output, so this is what Slurm reports: a time limit that was
        // exceeded, or too much memory. The path is relative to the folder of the plan.
        options.push(format!("--output={LOGS}/slurm-%a.out"));
        options.push("--requeue".to_owned());
    } else {
        // Relative to the folder of the plan, from which the job is submitted.
        options.push(format!("--output={LOGS}/merge.out"));
    }
    let cpus = if is_array { manifest.threads } else { 1 };
    if cpus == 0 {
        options.push("--exclusive".to_owned());
    } else {
        options.push(format!("--cpus-per-task={cpus}"));
    }
    options.extend(manifest.time.as_ref().map(|time| format!("--time={time}")));
    options.extend(manifest.mem.as_ref().map(|mem| format!("--mem={mem}")));
    let options: String = options.iter().map(|option| format!("#SBATCH {option}\n")).collect();
    let (script, argument) =
        if is_array { (PART, " \"$SLURM_ARRAY_TASK_ID\"") } else { (MERGE, "") };
    format!("#!/bin/sh\n{options}dir={}\nexec sh \"$dir/{script}\"{argument}\n", quoted(folder))
}

fn slurm_submit(manifest: &Manifest, folder: &str) -> String {
    format!(
        "{}cd \"$dir\"
# Further options are those of the variables SBATCH_ACCOUNT, SBATCH_PARTITION and others of sbatch.
job=$(sbatch --parsable --array=\"$parts\" {SLURM_PARTS})
job=${{job%%;*}}
# Without all parts there is nothing to merge.
merge=$(sbatch --parsable --dependency=\"afterok:$job\" --kill-on-invalid-dep=yes {SLURM_MERGE})
echo \"the parts $parts are job $job of Slurm, the merge is job ${{merge%%;*}}\"
",
        submit_head(manifest, folder, "Submits parts to Slurm, and the merge after them"),
    )
}

fn hyperqueue_submit(manifest: &Manifest, folder: &str) -> String {
    let cwd = toml_string(folder);
    let task = |outputs: [&str; 2], cpus: &str| {
        let [stdout, stderr] = outputs;
        format!(
            "cwd = {cwd}\nstdout = \"{stdout}\"\nstderr = \"{stderr}\"\n[[task.request]]\nresources = {{ \"cpus\" = {cpus} }}"
        )
    };
    let cpus = match manifest.threads {
        0 => "\"all\"".to_owned(),
        threads => threads.to_string(),
    };
    // The script of a part redirects its output.
    let of_part = task(["none", "none"], &cpus);
    let of_merge = task([&format!("{LOGS}/merge.out"), &format!("{LOGS}/merge.err")], "1");
    format!(
        "{}cd \"$dir\"
if ! command -v hq >/dev/null; then
    exec python3 {RUN} --parts \"$parts\"
fi
part={}
merge={}
{{
    numbers | while read -r number; do
        printf '[[task]]\\nid = %s\\ncommand = [\"sh\", \"{PART}\", \"%s\"]\\n%s\\n' \"$number\" \"$number\" \"$part\"
    done
    deps=$(numbers | paste -s -d , -)
    printf '[[task]]\\nid = 0\\ncommand = [\"sh\", \"{MERGE}\"]\\ndeps = [%s]\\n%s\\n' \"$deps\" \"$merge\"
}} >{JOB}
exec hq job submit-file {JOB}
",
        submit_head(manifest, folder, "Submits parts to HyperQueue, and the merge after them"),
        quoted(&of_part),
        quoted(&of_merge),
    )
}

/// Returns a text as a string of TOML.
fn toml_string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted += &format!("\\u{:04X}", u32::from(c)),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}
