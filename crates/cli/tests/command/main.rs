//! The command `sphvar` as users and scripts run it: the tests run the built binary in an empty
//! folder each and check standard output, standard error, the exit status and the files.

mod accuracy;
mod audits;
mod catalogues;
mod choices;
mod comparison_files;
mod determinism;
mod errors_of_files;
mod errors_of_outputs;
mod errors_of_usage;
mod expressions;
mod fixed_orientation;
mod forms_of_points;
mod forms_of_results;
mod grammar;
mod help;
mod inputs_and_outputs;
mod interrupts;
mod lists;
mod messages;
mod numbers;
mod outcome;
mod own_points;
mod pairs;
mod pipes;
mod precision;
mod qualities;
mod records;
mod render;
mod reproduction;
mod sampler_arguments;
mod schemas;
mod shards;
mod targets;
mod weights;
mod workplace;
