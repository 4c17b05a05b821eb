#pragma once
// The engine's own programs, run to their end in a folder: conversion, and runs of a model over some days.

#include <filesystem>
#include <string>
#include <vector>

namespace airside::tools {

/// How a program of the engine ended.
struct EngineRun {
  bool done = false;
  std::string words;  ///< how it ended, with the engine's Severe and Fatal lines; for complaints
};

/// Runs `program` in `folder`; its words go to the file engine.log there. The child ends with this process.
/// Errors: hal::InputError where it cannot be started; one that still runs after `limit_s` is killed, which is a run
///   that failed.
EngineRun run_engine_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                             const std::filesystem::path& folder, int limit_s = 600);

}  // namespace airside::tools
