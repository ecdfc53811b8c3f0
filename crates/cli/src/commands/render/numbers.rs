//! Arguments that consist of several numbers.

use std::str::FromStr;

/// Width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size(pub(super) [usize; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (width, height) = text.split_once('x').unwrap_or((text, text));
        let side = |text: &str| {
            text.parse().map_err(|_| format!("expected W or WxH as in 640x480, got \"{text}\""))
        };
        Ok(Self([side(width)?, side(height)?]))
    }
}

/// A comma-separated list of a fixed number of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Numbers<const N: usize, T>(pub(super) [T; N]);

impl<const N: usize, T: FromStr> FromStr for Numbers<N, T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<T>, _> = text.split(',').map(|item| item.trim().parse()).collect();
        let list = numbers.ok().and_then(|list| <[T; N]>::try_from(list).ok());
        list.map(Self).ok_or_else(|| format!("expected {N} numbers with commas, got \"{text}\""))
    }
}
