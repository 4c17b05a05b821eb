#pragma once
// Responses of cases that were commanded alike, or nearly: what one case's simulations tell about another's, and what
// must be simulated again. Whatever is shared is shared by what the recordings hold, never by what a file claims.

#include <cstdint>

#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

/// Of every box, fan coil and setpoint in every row, and of when the rows are: recordings of one digest were commanded
/// alike. Weather that was measured is not in it.
std::uint64_t command_digest(const sim::Recording& recording);

/// The same with the measured weather: recordings of one digest and one station make the same simulation, to the bit.
std::uint64_t recording_digest(const sim::Recording& recording);

/// The index of the case that is commanded most like the others: the smallest sum of differences, of setpoints in K and
/// of switches that stand otherwise, in both windows.  Errors: std::invalid_argument for no case.
std::size_t most_usual(const std::vector<const CaseData*>& cases);

/// One window's responses, simulated for one recording and asked for by others.
///   same recording    as they are
///   same commands     as they are, but the model as it is, and what only sensors show, from a run of its own
///   other commands    likewise, as a first screen; again() makes chosen candidates the recording's own
class SharedResponses {
 public:
  /// Cost: simulate_responses().
  SharedResponses(const Engine& engine, Library library, const sim::Recording& recording, int jobs,
                  const std::function<void()>& done = {});

  /// Draws buildings about the model as it is; whoever borrows then has them, under the recording's commands.
  /// Cost: as drawn_buildings().
  void draw_buildings(const Engine& engine, const sim::Recording& recording, int buildings, int jobs,
                      const std::function<void()>& done = {});

  struct Borrowed {
    Responses responses;
    bool own_commands = true;  ///< false: a first screen
  };
  /// `engine` simulates the same model.  Cost: one simulation at most.
  Borrowed borrowed(const Engine& engine, const sim::Recording& recording) const;

  /// Simulates the candidates of these places anew, both probes, under the recording's own commands; parameters that
  /// lie between two probes follow them.  Cost: two simulations a place that is not known from the base.
  void again(const Engine& engine, const sim::Recording& recording, const std::vector<std::string>& places,
             Responses& responses, int jobs) const;

 private:
  Library library_;
  Responses responses_;
  std::uint64_t commands_, all_;
};

/// Places that are simulated again for a case whose commands are its own.
constexpr int shortlist_places = 10;

/// What cases of one model share: both windows.
class SharedWindows {
 public:
  /// `buildings`: as Rules::buildings; drawn once, under the usual case's commands, for all cases.
  SharedWindows(const Engine& engine, const Library& library, const CaseData& usual, int jobs,
                const std::function<void()>& done = {}, int buildings = 0)
      : reference_(engine, library, usual.reference.recording, jobs, done),
        test_(engine, library, usual.test.recording, jobs, done) {
    reference_.draw_buildings(engine, usual.reference.recording, buildings, jobs, done);
    test_.draw_buildings(engine, usual.test.recording, buildings, jobs, done);
  }

  /// The case's responses. Where its commands are not those of the usual case, candidates are ranked by borrowed
  /// responses, under which its own base and all that only sensors show are its own already, and the first
  /// shortlist_places are simulated again.
  /// Cost: two simulations; for other commands as analyse() without findings, and 2 x shortlist_places a window.
  WindowResponses of(const Engine& engine, const CaseData& data, const Rules& rules, int jobs) const;

 private:
  SharedResponses reference_, test_;
};

}  // namespace airside::tools::gap
