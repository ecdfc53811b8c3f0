//! Integrands as they are named on the command line.

use std::path::Path;

use sphvar_samplers::Domain;
use sphvar_variance::{Cap, ClampedCosine, EnvironmentMap, Harmonic, Integrand, VonMisesFisher};

use crate::error::CliError;
use crate::files::{Channel, read_image};
use crate::memory::check_degree;
use crate::spec::{Spec, unknown_name};

/// The names and their parameters, for help texts.
pub(crate) const FORMS: &str = "ylm:l=4,m=0 | cap:degrees=60 | vmf:kappa=10 | cosine | \
     env:FILE[,channel=luminance|r|g|b] (EXR or HDR, 2:1)";

/// An integrand with the name by which tables know it.
pub(crate) struct NamedIntegrand {
    /// As it was written.
    pub(crate) name: String,
    /// The function.
    pub(crate) function: Box<dyn Integrand>,
}

/// The integrand of one specification; reads the file of an environment map.
pub(crate) fn parse_integrand(text: &str) -> Result<NamedIntegrand, CliError> {
    let mut spec = Spec::parse(text)?;
    let wrong = |error: sphvar_variance::Error| CliError::Usage(format!("{text}: {error}"));
    let (function, keys): (Box<dyn Integrand>, &[&str]) = match spec.name.as_str() {
        "ylm" => {
            let l = spec.require_number("l")?;
            let m = spec.take_number("m")?.unwrap_or(0);
            check_degree(text, l)?;
            (Box::new(Harmonic::new(l, m).map_err(wrong)?), &["l", "m"])
        }
        "cap" => {
            let degrees = spec.require_number("degrees")?;
            (Box::new(Cap::from_degrees(degrees).map_err(wrong)?), &["degrees"])
        }
        "vmf" => {
            let kappa = spec.require_number("kappa")?;
            (Box::new(VonMisesFisher::new(kappa).map_err(wrong)?), &["kappa"])
        }
        "cosine" => (Box::new(ClampedCosine), &[]),
        "env" => {
            let file = spec
                .take("")
                .or_else(|| spec.take("file"))
                .ok_or_else(|| CliError::Usage(format!("{text}: the file is missing: env:FILE")))?;
            let channel = channel(&mut spec)?;
            (Box::new(environment(Path::new(&file), channel)?), &["file", "channel"])
        }
        name => {
            return Err(unknown_name("integrand", name, &["ylm", "cap", "vmf", "cosine", "env"]));
        }
    };
    spec.finish(keys)?;
    Ok(NamedIntegrand { name: text.to_owned(), function })
}

fn channel(spec: &mut Spec) -> Result<Channel, CliError> {
    match spec.take("channel").as_deref() {
        None | Some("luminance") => Ok(Channel::Luminance),
        Some("r") => Ok(Channel::Red),
        Some("g") => Ok(Channel::Green),
        Some("b") => Ok(Channel::Blue),
        Some(other) => Err(unknown_name("channel", other, &["luminance", "r", "g", "b"])),
    }
}

fn environment(path: &Path, channel: Channel) -> Result<EnvironmentMap, CliError> {
    let image = read_image(path, channel)?;
    EnvironmentMap::new(image.width, image.height, image.values)
        .map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))
}

/// Refuses an integrand whose energy is not known on the domain.
pub(crate) fn check_domain(integrand: &NamedIntegrand, domain: Domain) -> Result<(), CliError> {
    integrand
        .function
        .energy(domain, 1)
        .map(|_| ())
        .map_err(|e| CliError::Usage(format!("{}: {e}", integrand.name)))
}
