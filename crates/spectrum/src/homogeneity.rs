mod accumulator;
mod audit;
mod judge;
mod rotator;
mod statistics;

pub use accumulator::HomogeneityAccumulator;
pub use audit::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAudit, MeanBias, OrderRatio,
};
