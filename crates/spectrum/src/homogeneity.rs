mod accumulator;
mod audit;
mod judge;
mod statistics;
mod turned;
mod turner;

pub use accumulator::HomogeneityAccumulator;
pub use audit::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAudit, MeanBias, OrderRatio,
};
pub use turned::{RotationLaw, TurnedSets};
