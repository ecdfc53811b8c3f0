//! Parsing, display and description of parameters from their declaration.

use crate::declaration::{Declaration, Declared};
use crate::{Error, Parameter, ParameterKind, Parametric, Spec, Value};

/// Sets the parameters given in a specification; the others are unchanged.
///
/// # Errors
///
/// [`Error`] for values outside their ranges and for missing or unknown parameters; some parameters
/// may already be set in that case.
pub fn read(parametric: &mut dyn Parametric, mut spec: Spec) -> Result<(), Error> {
    let names = take(parametric, &mut spec)?;
    spec.finish(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Takes the parameters from a specification that may contain others, and returns their names for
/// [`Spec::finish`].
///
/// # Errors
///
/// Those of [`read`], except for unknown parameters.
pub fn take(parametric: &mut dyn Parametric, spec: &mut Spec) -> Result<Vec<String>, Error> {
    let declared = Declaration::read(parametric, spec)?;
    Ok(declared.into_iter().map(|given| given.parameter().with_values()).collect())
}

/// Returns the usage form, such as `ylm:l=4[,m=0]`: examples of the required parameters and, in
/// brackets, the optional ones with defaults or valid values.
#[must_use]
pub fn form(name: &str, default: &mut dyn Parametric) -> String {
    let mut form = name.to_owned();
    let mut separator = ':';
    for declared in Declaration::describe(default) {
        let value = match (&declared.kind, &declared.value) {
            (ParameterKind::Choice(names), _) => names.join("|"),
            (_, Some(value)) => value.to_string(),
            (ParameterKind::Word, None) => "NAME".to_owned(),
            (ParameterKind::File, None) => "FILE".to_owned(),
            (_, None) => "NUMBER".to_owned(),
        };
        let is_bare = declared.kind.is_bare() && separator == ':';
        let item = if is_bare { value } else { format!("{}={value}", declared.name) };
        let item = format!("{separator}{item}");
        form.push_str(&if declared.is_required() { item } else { format!("[{item}]") });
        separator = ',';
    }
    form
}

/// Returns every parameter, with the values of `parametric` as defaults.
#[must_use]
pub fn describe(parametric: &mut dyn Parametric) -> Vec<Parameter> {
    Declaration::describe(parametric).into_iter().map(Declared::parameter).collect()
}

/// Returns `name:key=value,key=value` with the required parameters and those whose values differ
/// from `default`; the name alone if there are none.
#[must_use]
pub fn text(name: &str, parametric: &mut dyn Parametric, default: &mut dyn Parametric) -> String {
    let defaults = Declaration::describe(default);
    let is_default = |given: &Declared, value: &str| {
        let same = defaults.iter().find(|default| default.name == given.name);
        let same = same.and_then(|default| default.value.as_ref());
        same.is_some_and(|default| default.to_string() == value) && !given.is_required()
    };
    let mut text = name.to_owned();
    let mut separator = ':';
    for given in Declaration::describe(parametric) {
        let Some(value) = given.value.as_ref().map(Value::to_string) else { continue };
        if is_default(&given, &value) {
            continue;
        }
        text.push(separator);
        // A bare value comes first.
        if !(given.kind.is_bare() && separator == ':') {
            text.push_str(given.name);
            text.push('=');
        }
        text.push_str(&value);
        separator = ',';
    }
    text
}
