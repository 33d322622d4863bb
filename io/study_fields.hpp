// SPDX-License-Identifier: Apache-2.0
// The members of a study's structs by their names in study.json, shared by writer and reader:
// each_field(s, field) calls field(name, member) for each.

#pragma once

#include "io/study_result.hpp"

#include <type_traits>

namespace elastogen {

/// Struct is the type, S the type with or without const.
template <class S, class Struct>
concept SameStruct = std::is_same_v<std::remove_const_t<S>, Struct>;

template <SameStruct<StudyMachine> S, class Field>
void each_field(S& s, const Field& field) {
  field("cpu", s.cpu);
  field("cores", s.cores), field("memory_bytes", s.memory_bytes);
  field("copy_bandwidth", s.copy_bandwidth);
}

template <SameStruct<StudyHeader> S, class Field>
void each_field(S& s, const Field& field) {
  field("scene", s.scene);
  field("scene_text", s.scene_text);
  field("command", s.command);
  field("commit", s.commit);
  field("date", s.date);
  field("threads", s.threads), field("repeats", s.repeats);
  field("machine", s.machine);
}

template <SameStruct<StepTime> S, class Field>
void each_field(S& s, const Field& field) {
  field("lower_quartile", s.lower_quartile), field("median", s.median),
      field("upper_quartile", s.upper_quartile);
}

template <SameStruct<LoopBudget> S, class Field>
void each_field(S& s, const Field& field) {
  field("outer", s.outer), field("inner", s.inner), field("modes", s.modes);
}

template <SameStruct<EnergySeries> S, class Field>
void each_field(S& s, const Field& field) {
  field("kinetic", s.kinetic), field("elastic", s.elastic), field("hourglass", s.hourglass);
  field("gravity", s.gravity), field("contact", s.contact), field("total", s.total);
}

template <SameStruct<ErrorSeries> S, class Field>
void each_field(S& s, const Field& field) {
  field("steps", s.steps), field("max", s.max);
}

template <SameStruct<StudyErrors> S, class Field>
void each_field(S& s, const Field& field) {
  field("reference", s.reference);
  field("step", s.step), field("free_run", s.free_run);
  field("iou", s.iou);
  field("energy_drift", s.energy_drift);
  field("reference_change", s.reference_change);
}

template <SameStruct<StudyRun> S, class Field>
void each_field(S& s, const Field& field) {
  field("name", s.name), field("solver", s.solver), field("element", s.element);
  field("h", s.h), field("dt", s.dt);
  field("tolerance", s.tolerance);
  field("loops", s.loops);
  field("steps", s.steps), field("voxels", s.voxels), field("elements", s.elements),
      field("dofs", s.dofs);
  field("step_ms", s.step_ms);
  field("state_bytes", s.state_bytes);
  field("state_copies_per_second", s.state_copies_per_second);
  field("outer", s.outer), field("inner", s.inner);
  field("converged_share", s.converged_share);
  field("worst_residual", s.worst_residual);
  field("min_j", s.min_j);
  field("residual", s.residual);
  field("energy", s.energy);
  field("solver_error", s.solver_error);
  field("discretisation_error", s.discretisation_error);
}

template <SameStruct<ReachedError> S, class Field>
void each_field(S& s, const Field& field) {
  field("error", s.error), field("run", s.run), field("ms", s.ms);
}

template <SameStruct<TimeToError> S, class Field>
void each_field(S& s, const Field& field) {
  field("family", s.family), field("measure", s.measure);
  field("reference", s.reference);
  field("solver", s.solver);
  field("levels", s.levels);
}

template <SameStruct<StudySweep> S, class Field>
void each_field(S& s, const Field& field) {
  field("name", s.name), field("variable", s.variable), field("unit", s.unit);
  field("family", s.family);
  field("measure", s.measure);
  field("x", s.x), field("error", s.error), field("order", s.order);
}

template <SameStruct<Outline> S, class Field>
void each_field(S& s, const Field& field) {
  field("name", s.name);
  field("lines", s.lines);
}

template <SameStruct<ShapeOverlay> S, class Field>
void each_field(S& s, const Field& field) {
  field("title", s.title);
  field("time", s.time);
  field("horizontal", s.horizontal), field("vertical", s.vertical);
  field("outlines", s.outlines);
}

template <SameStruct<StudyFigure> S, class Field>
void each_field(S& s, const Field& field) {
  field("name", s.name);
  field("value", s.value), field("reference", s.reference), field("tolerance", s.tolerance);
  field("unit", s.unit);
  field("pass", s.pass);
}

template <SameStruct<StudyResult> S, class Field>
void each_field(S& s, const Field& field) {
  field("header", s.header);
  field("runs", s.runs);
  field("time_to_error", s.time_to_error);
  field("sweeps", s.sweeps);
  field("overlays", s.overlays);
  field("figures", s.figures);
}

}  // namespace elastogen
