#pragma once
// How much a right model may be off in a measured period after it was fitted to another one: asked of buildings that
// differ from it as buildings do.

#include <functional>
#include <vector>

#include "tools/gap/inference/reference_fit.hpp"

namespace airside::tools::gap {

/// Mean and covariance of a fitted model's residual in the measured window, over buildings in which nothing is missing.
struct StructureEnsemble {
  Eigen::MatrixXd mean;                     ///< bins x channels; what buildings have in common that no parameter has
  std::vector<Eigen::MatrixXd> directions;  ///< bins x channels; one standard deviation each, largest first
  int rooms = 0;
  /// Mean square of a whitened value of what a building adds to noise, whose own is 1: alone, and by the directions of
  /// the others.  The second is what drawn buildings leave unsaid; the more are drawn, the smaller.
  double adds_alone = 0, adds = 0;
};

/// What each of `rooms` buildings about the changed model shows, less `shown`, which is what that model shows.
/// Shape: bins x channels each.  Empty where the engine cannot draw buildings.
/// Cost: `rooms` simulations on `jobs` threads; done() after each.  Errors: as Engine::simulate.
std::vector<Eigen::MatrixXd> drawn_buildings(const Engine& engine, const Changes& at, const Eigen::MatrixXd& shown,
                                             const sim::Recording& recording, int rooms, int jobs,
                                             const std::function<void()>& done = {});

/// Draws `rooms` buildings about the fitted model, lets each live through both recordings, fits the model's parameters
/// and structural directions to its reference period linearly, and keeps what is left of its measured period:
///   d_i = (J_r' J_r + I)^-1 J_r' r_i,  e_i = t_i - J_t d_i,  m = 1/n sum_i e_i,
///   C = 1/n sum_i (e_i - m) (e_i - m)'  = sum_k d_k d_k'
/// `about`: the parameters' responses in the measured window, about the fitted model.
/// Responses::buildings, where there are any, are taken as they are: about the model as it is; d_i moves freely.
/// Without a reference period all of it stays.
/// Empty where the engine cannot draw buildings.
/// Cost: 2 rooms + 2 simulations; none where the responses have the buildings.  Errors: as Engine::simulate.
/// Source: docs/gap-workflow.md, "Buildings that differ".
StructureEnsemble structure_ensemble(const Engine& engine, const ReferenceFit& fit, const Window& reference,
                                     const Window& test, const WindowResponses& responses,
                                     const std::vector<Parameter>& about, int rooms, int jobs);

}  // namespace airside::tools::gap
