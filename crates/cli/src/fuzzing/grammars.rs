//! The grammars of arguments, samplers, integrands and warps.

use std::path::Path;

use clap::Parser;
use sphvar_integrands::{NoFiles, WarpExpression};
use sphvar_samplers::{Domain, Pattern};
use sphvar_variance::WarpedPattern;

use super::{text, texts};
use crate::args::Cli;
use crate::error::CliError;
use crate::session::Session;

pub(super) fn sampler_names(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "jittered,white-noise,healpix",
        "poisson-disk:radius=2,mode=saturated,fibonacci",
        "step:alpha=1.2",
        "profile:b=2,alpha=1,to=2",
        "ccvt:capacity=64,mass=fibonacci",
        "file:none-{n}.csv,columns=\"ra,dec\",fold=yes",
        "spiral,sobol,halton,hammersley,lloyd,riesz,blue,best-candidate,equal-area",
    ])
}

pub(super) fn samplers(input: &[u8], _: &Path) -> Result<(), CliError> {
    for pattern in
        crate::patterns::parse_patterns::<Pattern>(&text(input), &Session::default().muted())?
    {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let n = pattern.nearest_count(48, domain);
            crate::patterns::build(&pattern, n, domain, true)?;
        }
    }
    Ok(())
}

pub(super) fn integrand_names(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "cap:degrees=60",
        "2 * ylm:l=4,m=-3 + 0.5 * cosine",
        "rotate(cap:degrees=60, 10, 20, 30)",
        "vmf:kappa=50 * half-space",
        "phong:n=20 - (gaussian:sigma=0.2)",
        "env:none.exr,channel=red",
        "map:none.fits,field=1",
    ])
}

pub(super) fn integrand(input: &[u8], _: &Path) -> Result<(), CliError> {
    crate::integrands::parse_integrand(&text(input), &Session::default().muted()).map(drop)
}

pub(super) fn warp_names(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "vmf:kappa=50 @ 40/10",
        "0.3 * cosine + 0.7 * env:none.exr,floor=0.1",
        "env:\"a + b.exr\",channel=r,interpolation=constant,up=y @ 90/90 * cosine @ 0/1/2",
        "cap:degrees=30 + phong:n=2 + octahedral + cylinder",
    ])
}

/// Reads the expression again from its text, and builds its warps.
pub(super) fn warps(input: &[u8], _: &Path) -> Result<(), CliError> {
    let warp: WarpExpression = text(input).parse().map_err(CliError::usage)?;
    assert_eq!(warp.to_string().parse().ok().as_ref(), Some(&warp), "{warp}");
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        warp.strategies(domain, &NoFiles).map_err(CliError::usage)?;
    }
    Ok(())
}

pub(super) fn warped_names(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "sobol:warp=cosine",
        "jittered-square:warp=\"env:none.exr * cosine\"",
        "ccvt-square:capacity=64,warp=\"0.3 * cosine + 0.7 * env:\\\"a,b.exr\\\"\",heuristic=power",
        "halton:warp=vmf:kappa=50,scramble=no",
    ])
}

/// Reads the pattern again from its text, and finds its numbers of points.
pub(super) fn warped_pattern(input: &[u8], _: &Path) -> Result<(), CliError> {
    let pattern: WarpedPattern = text(input).parse().map_err(CliError::usage)?;
    assert_eq!(pattern.to_string().parse().ok().as_ref(), Some(&pattern), "{pattern}");
    assert_eq!(pattern.counts(48).iter().sum::<usize>(), pattern.nearest_count(48), "{pattern}");
    Ok(())
}

pub(super) fn argument_lists(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "compare jittered,fibonacci -n 100,1000 --integrand cap:degrees=60 -o out",
        "spectrum poisson-disk -n 1024 -m 200 --shard 1/2 --save a.shard",
        "render cornell --study -n 16..1024 --mode rotated --samplers ccvt,step -o f.png --crop 1,2,3,4",
        "choose --integrand vmf:kappa=50 --error 0.1% --hemisphere --json",
        "healpix ang2pix --nside 8 --nested --degrees in.csv -o out.npy",
        "bounds healpix -n 12 --profile poly:b=2,alpha=1 -s 3 -j 2",
        "eval cap-power --degrees 60 --lmax 10",
        "variance fibonacci -n 12 --integrand cosine -m 4 --until-rel 1%",
    ])
}

pub(super) fn arguments(input: &[u8], _: &Path) -> Result<(), CliError> {
    let input = text(input);
    let words = std::iter::once("sphvar").chain(input.split_whitespace());
    // Messages of clap contain line breaks; the test is about errors of one line.
    Cli::try_parse_from(words).map(drop).map_err(|_| CliError::Usage(String::new()))
}
