#pragma once
// Runs of a study in one file: to be kept where their folder does not fit, and to go on from on another machine.

#include <string>

#include "tools/study/method/run.hpp"

namespace airside::tools {

/// Writes every run that the study's folder holds into `file`, in order of name. Weights are not kept: a row that
/// starts from them makes them again.  Returns how many.  Errors: hal::InputError for a file that cannot be written.
int keep_runs(const MethodStudy& study, const std::string& file);

/// Puts the runs of `file` into the study's folder; what the folder has already stays as it is.  Returns how many were
/// put there.  Errors: hal::InputError naming file and field for one that keep_runs() did not write or that is of
/// another study, before any run is put anywhere.
int take_runs(const MethodStudy& study, const std::string& file);

}  // namespace airside::tools
