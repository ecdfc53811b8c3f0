//! Profiles, bounds and rates against closed forms and searches.

mod checking;
mod closed_forms;
mod rates;
mod special_functions;
mod tightest;
