# What a developer runs by hand; `just --list` shows it.

# The main job.
compare *ARGS:
    cargo run --release -- compare {{ARGS}}

# Everything that CI checks.
check:
    bash .ci/run

# Everything that is checked before an issue is closed.
check-all:
    bash .ci/full

# The fast tests.
test:
    cargo test --workspace

# All tests, with the slow ones and statistics.
test-all:
    cargo test --workspace -- --include-ignored

# All packages for crates.io, into target/package.
package:
    cargo package --workspace --exclude sphvar-tests --no-verify

# A stripped binary with completions, manual pages and the licences of its dependencies, into dist/.
dist:
    bash .ci/dist

# The package for Python: a wheel for CPython 3.10 or later and its sources, into python/dist/.
wheel *ARGS:
    bash .ci/wheel {{ARGS}}

# The tests of the package for Python, with a wheel and every CPython that is found, its types and its notebooks.
python-test:
    bash .ci/python

# Execute the scripts of docs/notebooks and write the notebooks, in an environment with the package: `just notebooks 1_pattern`.
notebooks *ARGS:
    python3 .ci/notebooks.py {{ARGS}}

# Write docs/schema.json, the JSON schema of all documents of `--json`, from their types.
schema:
    SPHVAR_WRITE_SCHEMA=1 cargo test -p sphvar-cli --lib schema

# Mutated inputs for every reader and grammar, 10^6 of text and 10^5 of binary forms; `just fuzz --seconds 60`.
fuzz *ARGS:
    cargo run --profile test -p sphvar-tests --example fuzz -- {{ARGS}}

# A hundred interrupts at random times over all commands that write files.
interrupts COUNT="100":
    SPHVAR_INTERRUPTS={{COUNT}} cargo test -p sphvar-cli --test command -- interrupts

# A hundred `kill -9` at random times over all commands with parts, and over their merges.
kills COUNT="100":
    SPHVAR_KILLS={{COUNT}} cargo test -p sphvar-cli --test command -- kills

# Parts of a comparison and of a catalogue on HyperQueue, which is installed in a folder of its own; some are killed.
cluster-hyperqueue:
    bash cluster/hyperqueue

# The same on Slurm; as root, its packages are installed with apt-get where they are missing.
cluster-slurm:
    bash cluster/slurm

# The same on Dask distributed, which is installed in a folder of its own.
cluster-dask:
    bash cluster/dask

# Benchmarks of every crate that has them.
bench *ARGS:
    cargo bench --workspace {{ARGS}}

# Measured errors beside speed, and the hard cases: `just accuracy --quick harmonics`.
accuracy *ARGS:
    cargo run --release -- accuracy {{ARGS}}

# The fast transform beside ducc0, in one run.
peers *ARGS:
    python3 benches/peers/transforms.py {{ARGS}}

# Speed and error beside healpy, cdshealpix, scipy and ducc0: indexing, harmonics, transforms.
peers-accuracy *ARGS:
    python3 benches/peers/accuracy.py {{ARGS}}

# Record the values of healpy again that the tests of sphvar-healpix compare with.
healpy-values:
    python3 benches/peers/healpix_values.py

# Write the small HEALPix maps of the tests again with healpy.
healpy-maps:
    python3 benches/peers/healpix_maps.py

# Occlusion rays in a mesh beside Embree.
occlusion-peer *ARGS:
    python3 benches/peers/occlusion.py {{ARGS}}

# The bounds of the thesis against every pattern that it gives them for, those that take minutes too.
bounds-verdicts *ARGS:
    cargo run --release -- bounds white-noise -n 4096 -m 1000 {{ARGS}}
    cargo run --release -- bounds poisson-disk -n 4096 -m 600 {{ARGS}}
    cargo run --release -- bounds jittered -n 3888 -m 1000 {{ARGS}}
    cargo run --release -- bounds ccvt:capacity=64,mass=white -n 1024 -m 400 {{ARGS}}
    cargo run --release -- bounds ccvt:capacity=64,mass=white -n 4096 -m 160 {{ARGS}}
    cargo run --release -- bounds ccvt:capacity=256,mass=white -n 1024 -m 60 {{ARGS}}
    cargo run --release -- bounds ccvt:capacity=1024,mass=white -n 256 -m 60 {{ARGS}}
    cargo run --release -- bounds ccvt:capacity=64,mass=fibonacci -n 1024 -m 400 {{ARGS}}

# Predicted over measured variance of every pattern, SECONDS of core time for trials and spectrum of a cell each.
closed-loop SECONDS="1":
    cargo run --release -p sphvar-tests --example closed_loop -- {{SECONDS}}

# The error of choose's best pattern over that of the best of a grid of parameters.
choose-study *ARGS:
    cargo build --release
    python3 benches/choose_study.py {{ARGS}}

# Coverage of the intervals of measured variances, with few and with many trials in the support of the integrand.
interval-coverage SEEDS="200":
    cargo run --release -p sphvar-tests --example interval_coverage -- {{SEEDS}}

# Draw the patterns and spectra in the documentation of sphvar-samplers again.
pattern-pictures:
    cargo build --release
    python3 benches/pattern_pictures.py

# Figure 7.9 c of the thesis: mean squared errors of ambient occlusion, with halves of sphere sets as there.
figure-7-9 *ARGS:
    cargo run --release -- render cornell --study -n 16..1024 --mode rotated --samplers white-noise,jittered,poisson-disk,ccvt,healpix,fibonacci,step -o figure-7-9.png {{ARGS}}

# Figures 4.13, 7.5, 7.6 and 7.8 of the thesis as contact sheets.
scene-figures *ARGS:
    cargo run --release -- render cornell --integral light --sheet reference,fibonacci@shared,fibonacci@rotated -n 128,1024 -o figure-4-13.png {{ARGS}}
    cargo run --release -- render cornell --sheet white-noise@rotated,jittered@rotated,poisson-disk@rotated -n 24,96,384 -o figure-7-5.png {{ARGS}}
    cargo run --release -- render cornell --sheet white-noise@rotated,ccvt@rotated,healpix@rotated -n 24,96,384 -o figure-7-6.png {{ARGS}}
    cargo run --release -- render cornell --sheet fibonacci@shared,fibonacci@rotated,healpix@shared -n 384 -o figure-7-8.png {{ARGS}}
