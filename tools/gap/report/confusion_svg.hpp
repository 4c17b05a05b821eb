#pragma once
// The confusion matrix as a picture.

#include <string>

#include "tools/gap/score/score.hpp"

namespace airside::tools::gap {

/// One cell a pair of hidden and said, its count in it, coloured by its share of the row: blue and framed what is
/// right, orange a wrong name, grey an abstention. A file of its own; its styles touch nothing else when put into a
/// page. Shape: 24 x 20 user units a cell, beside labels as wide as they need. Errors: std::invalid_argument when the
/// counts do not have the labels' shape.
std::string confusion_svg(const Confusion& confusion, const std::string& title);

}  // namespace airside::tools::gap
