# What a developer runs by hand; `just --list` shows it.

# The main job.
compare *ARGS:
    cargo run --release -- compare {{ARGS}}

# Everything that CI checks.
check:
    bash .ci/run

# All tests.
test:
    cargo test --workspace

# Benchmarks of every crate that has them.
bench *ARGS:
    cargo bench --workspace {{ARGS}}

# The accuracy of the Legendre functions against the 25-digit table.
legendre-accuracy:
    cargo run --release -p sphvar-sh --example accuracy

# The fast transform beside ducc0, in one run.
peers *ARGS:
    python3 benches/peers/transforms.py {{ARGS}}

# Record the values of healpy again that the tests of sphvar-healpix compare with.
healpy-values:
    python3 benches/peers/healpix_values.py

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
