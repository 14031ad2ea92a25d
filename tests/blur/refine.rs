//! Refinement: what is drawn is near its curve, without cracks, within its budget.
