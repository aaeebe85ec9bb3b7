// What the engine answers; its fields are those of `torquewise --json`.

export interface Problem { message: string; help: string | null; is_unnamed?: boolean }

export interface Column { name: string; values: (number | null)[] }

export interface SignalColumns {
  columns?: string | string[];
  unit?: string;
  torque_constant?: number | number[];
  gear?: number | number[];
}

export interface Profile {
  joints?: string[];
  rate?: number | null;
  t?: { column: string; unit?: string | null } | null;
  q?: SignalColumns | null;
  dq?: SignalColumns | null;
  ddq?: SignalColumns | null;
  tau?: SignalColumns | null;
}

export interface Found {
  joints: { name: string; q_range: [number, number]; dq_peak: number; tau_std: number | null }[];
  rows: number;
  seconds: number;
  rate_hz: number;
  patterns: { name: string; rows: number }[];
  missing: string[];
  ignored_columns: string[];
}

// An option of a fit, and what it is set to.
export interface Keyword {
  name: string;
  word?: string[];
  whole?: { start: number; end: number };
  number?: null;
  switch?: null;
  text?: null;
  texts?: null;
}

export interface Opened {
  options: Keyword[];
  columns: Column[];
  suggestion?: { profile: Profile; reasons: string[]; is_complete: boolean };
  log?: { found: Found; warnings: string[]; is_filtered: boolean; profile: string | null };
  refused?: Problem;
}

export interface Fitted {
  summary: {
    verdict: string;
    because: string[];
    joints: string[];
    rows: number;
    residual_rms: number[];
    residual_percent: number[];
    held_out_percent: number[];
    held_out_by_region_percent: number[];
    active: number[];
  };
  warnings: string[];
  notes: string[];
  report: string;
  equations: string;
  is_chain: boolean;
  model: string;
}

export interface Scores {
  scores: {
    rows: number;
    interval_coverage_percent?: number[];
    joints: { name: string; rmse: number; nrmse_percent: number; r2: number | null; raw_nrmse_percent?: number }[];
  };
  warnings: string[];
  notes: string[];
}
