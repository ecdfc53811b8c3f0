mod accumulator;
mod audit;
mod judge;
mod statistics;
mod turner;

pub use accumulator::HomogeneityAccumulator;
pub use audit::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAudit, MeanBias, OrderRatio,
};
