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

# Predicted over measured variance of every pattern, SECONDS of core time for trials and spectrum of a cell each.
closed-loop SECONDS="1":
    cargo run --release -p sphvar-tests --example closed_loop -- {{SECONDS}}
