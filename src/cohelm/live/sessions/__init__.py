"""Storage of live rides: logs, measures, maps, reports, and the audit log."""
