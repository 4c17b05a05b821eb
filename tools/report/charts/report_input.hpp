#pragma once
// What a report shows, as plain data: any command fills it in, one writer turns it into a page and SVG files.
// Texts may come from site files and are escaped by the writer. Numbers that are not finite show as gaps.

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace airside::tools {

/// How much a series matters to the reader; decides colour, width and dash.
enum class SeriesRole {
  plain,
  main,       ///< the one the report is about
  muted,      ///< context, thin
  reference,  ///< target, limit or schedule, dashed
};

struct ChartSeries {
  std::string name;
  std::vector<double> y;  ///< one value an x; a single value is a level line
  SeriesRole role = SeriesRole::plain;
  bool stepped = false;  ///< held until the next x, as a setpoint is
};

/// A shaded interval of x.
struct ChartBand {
  double from = 0;
  double to = 0;
};

/// A stretch of x in which something holds, such as a control mode: shaded behind the curves, with an edge at the top.
struct ChartStretch {
  double from = 0;
  double to = 0;
  std::string kind;  ///< run, expert, release or alarm: a colour band-* of palette.css
  std::string name;  ///< one a kind, for people
  std::string why;
};

/// Lines over a shared x. Units: x in seconds of civil time when x_is_time, else as x_label says.
/// Charts over time in one report zoom and move their cursors together.
struct LineChart {
  std::string title;
  std::string note;       ///< one sentence on how to read it
  std::string unit;       ///< of y, on the axis
  std::vector<double> x;  ///< increasing
  std::vector<ChartSeries> series;
  std::vector<ChartBand> bands;
  std::string band_name;  ///< what the shading means
  std::vector<ChartStretch> stretches;
  std::string stretches_name;  ///< what they are: "mode"; beside the cursor stands which one holds
  std::string otherwise;       ///< what holds between them
  std::string x_label;         ///< when x is not a time
  bool x_is_time = true;
  bool log_axis = false;        ///< values at or below zero become gaps
  int decimals = 2;             ///< of the values beside the cursor
  std::optional<double> y_min;  ///< the axis reaches at least down to here
  std::optional<double> y_max;  ///< the axis reaches at least up to here
  /// Instead of numbers on the axis: the name of y = 0, 1, .. A series that is half a place above it or more is
  /// `raised` there, such as a box that is closed.
  std::vector<std::string> y_names;
  std::string raised;
};

/// One method's bars over the categories.
struct BarGroup {
  std::string name;
  std::vector<double> y;       ///< one a category
  std::vector<double> spread;  ///< whisker, +- ; empty for none
  SeriesRole role = SeriesRole::plain;
};

/// Grouped bars from zero. A group that towers above all others is cut, and says its value at the cut.
struct BarChart {
  std::string title;
  std::string note;
  std::string unit;
  std::vector<std::string> categories;
  std::vector<BarGroup> groups;
  int decimals = 2;
};

/// A number with spread, or a text. Empty when both are absent.
struct TableCell {
  std::optional<double> value;
  std::optional<double> spread;
  std::string text;
};

struct TableColumn {
  std::string name;
  std::string unit;
  int decimals = 3;
  bool mark_lowest = true;  ///< the least value among the rows that compete is printed bold
};

struct TableRow {
  std::string name;
  std::vector<TableCell> cells;
  SeriesRole role = SeriesRole::plain;  ///< main is highlighted; reference is set apart
  bool competes = true;                 ///< false: never marked as the best of a column
};

struct ReportTable {
  std::string title;
  std::string note;
  std::string row_header = "method";
  bool prose = false;  ///< cells are sentences: they stand left and wrap
  std::vector<TableColumn> columns;
  std::vector<TableRow> rows;
};

struct ReportNote {
  std::string title;
  std::vector<std::string> paragraphs;
};

/// Pictures that are drawn already, side by side where there is room. They take their colours from the page.
struct PictureRow {
  std::string title;
  std::string note;
  std::vector<std::string> svg;
};

using ReportBlock = std::variant<LineChart, BarChart, ReportTable, ReportNote, PictureRow>;

/// A figure that deserves large type.
struct KeyFigure {
  std::string value;
  std::string unit;
  std::string label;
  std::string note;  ///< e.g. the same figure of the schedule
};

struct ReportFact {
  std::string name;
  std::string value;
};

struct ReportInput {
  std::string title;
  std::string subtitle;
  std::string headline;  ///< one or two sentences an operator understands
  std::vector<KeyFigure> figures;
  std::vector<ReportBlock> blocks;  ///< in the order in which they are read
  std::vector<ReportFact> facts;    ///< everything needed to repeat the run
  std::string command;              ///< the exact command that repeats it
};

}  // namespace airside::tools
