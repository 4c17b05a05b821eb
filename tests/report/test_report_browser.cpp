// The page in a real browser: it draws, complains about nothing, and asks for nothing.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "report/synthetic_run.hpp"
#include "tools/gap/report/gap_charts.hpp"
#include "tools/report/report.hpp"

namespace airside::tools {
namespace {

std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return text;
  std::array<char, 65536> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) text.append(buffer.data(), n);
  pclose(pipe);
  return text;
}

std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (!output_of(std::string("command -v ") + name).empty()) return name;
  }
  return "";
}

class ReportInABrowser : public ::testing::Test {
 protected:
  void SetUp() override {
    program_ = browser();
    if (program_.empty()) {
      std::fprintf(stderr,
                   "\n*** SKIPPED: no chromium on this machine, the report was not opened in a browser.\n"
                   "*** Install it with `apt-get install chromium`.\n\n");
      GTEST_SKIP() << "no chromium";
    }
    std::string pattern = (std::filesystem::path(::testing::TempDir()) / "airside_browser_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }

  /// Opens `page`; stdout is what `what` asks for, the browser's own log goes to log().
  std::string open(const std::filesystem::path& page, const std::string& what) {
    return output_of("timeout 80 " + program_ +
                     " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
                     "--disable-background-networking --disable-component-update --disable-sync --disable-extensions "
                     "--host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr --v=0 --virtual-time-budget=8000 "
                     "--log-net-log=" +
                     (folder_ / "net.json").string() + " --user-data-dir=" + (folder_ / "profile").string() + " " +
                     what + " file://" + page.string() + " 2>" + (folder_ / "log").string());
  }
  std::string text_of(const char* name) const {
    std::ifstream file(folder_ / name);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

  std::string program_;
  std::filesystem::path folder_;
};

std::size_t matches(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), regex), std::sregex_iterator()));
}

/// Requests for pages of the network that are not the browser's own housekeeping.
std::size_t foreign_requests(const std::string& net_log) {
  return matches(net_log, R"("url":"https?://(?!([a-z0-9.-]+\.)?(google|googleapis|gvt1|gvt2|gstatic)\.com))");
}

TEST_F(ReportInABrowser, DrawsEveryChartWithoutAComplaintOrARequest) {
  write_report(folder_ / "report.html", make_run_report(synthetic_run()));
  const std::string dom = open(folder_ / "report.html", "--window-size=1200,900 --dump-dom");
  EXPECT_EQ(matches(dom, "<canvas"), 6u);
  EXPECT_NE(dom.find("data-drawn=\"6\""), std::string::npos);
  EXPECT_GT(matches(dom, "class=\"bar "), 100u);
  EXPECT_GE(matches(dom, "class=\"u-legend"), 6u);
  const std::string log = text_of("log");
  EXPECT_EQ(log.find("CONSOLE"), std::string::npos) << log;
  const std::string requests = text_of("net.json");
  ASSERT_FALSE(requests.empty());
  EXPECT_EQ(foreign_requests(requests), 0u);
}

/// Stroke and pattern of the keys of each legend.
std::vector<std::vector<std::pair<std::string, std::string>>> keys_of_legends(const std::string& dom) {
  std::vector<std::vector<std::pair<std::string, std::string>>> legends;
  const std::string begin = "class=\"u-legend", end = "</table>";
  const std::regex key("<path d=\"M0 5H30\" stroke=\"([^\"]*)\" stroke-width=\"[^\"]*\" stroke-dasharray=\"([^\"]*)\"");
  for (std::size_t at = dom.find(begin); at != std::string::npos; at = dom.find(begin, at + 1)) {
    const std::string legend = dom.substr(at, dom.find(end, at) - at);
    auto& keys = legends.emplace_back();
    for (std::sregex_iterator m(legend.begin(), legend.end(), key); m != std::sregex_iterator(); ++m)
      keys.emplace_back((*m)[1], (*m)[2]);
  }
  return legends;
}

TEST_F(ReportInABrowser, TellsTheLinesOfAChartApartWithoutColour) {
  RunRecord run = synthetic_run(2);
  run.mode.assign(run.row_time.size(), "learn");
  run.reason.assign(run.row_time.size(), "none");
  std::fill_n(run.mode.begin() + 100, 10, "release");
  write_report(folder_ / "report.html", make_run_report(run));
  const std::string dom = open(folder_ / "report.html", "--window-size=1200,900 --dump-dom");
  const auto legends = keys_of_legends(dom);
  ASSERT_EQ(legends.size(), 7u);
  EXPECT_EQ(legends[0].size(), 7u) << "five rooms, mean and target; no key of the mode beside the cursor";
  for (std::size_t i = 0; i < legends.size(); ++i) {
    std::set<std::string> strokes, dashes;
    for (const auto& [stroke, dash] : legends[i]) {
      strokes.insert(stroke);
      dashes.insert(dash);
    }
    EXPECT_FALSE(legends[i].empty()) << i;
    EXPECT_EQ(dashes.size(), legends[i].size()) << "patterns of chart " << i;
    EXPECT_EQ(strokes.size(), legends[i].size()) << "colours of chart " << i;
  }
  EXPECT_EQ(matches(dom, "<i class=\"release\"></i>Released"), 4u) << "rooms, setpoint, power, outdoor";
  EXPECT_EQ(matches(dom, ">mode<"), 5u) << "beside their cursors, and the line of the chart of modes";
  EXPECT_EQ(text_of("log").find("CONSOLE"), std::string::npos) << text_of("log");
}

TEST_F(ReportInABrowser, AForeignRequestWouldBeSeen) {
  std::ofstream(folder_ / "leaky.html") << "<img src='http://tiles.example/1.png'>";
  open(folder_ / "leaky.html", "--dump-dom");
  EXPECT_GT(foreign_requests(text_of("net.json")), 0u);
}

TEST_F(ReportInABrowser, ShowsHostileNamesAsText) {
  RunRecord run = synthetic_run(2);
  const std::string attack =
      "</script><script>console.error('owned')</script><img src=x onerror=console.error('owned')>";
  run.site = attack;
  run.room_temp_degc[0].name = attack;
  run.methods[1].name = attack;
  run.room_names[0] = attack;
  write_report(folder_ / "report.html", make_run_report(run));
  const std::string dom = open(folder_ / "report.html", "--dump-dom");
  EXPECT_EQ(matches(dom, "<canvas"), 6u);
  EXPECT_EQ(matches(dom, "<img"), 0u);
  EXPECT_EQ(text_of("log").find("CONSOLE"), std::string::npos) << text_of("log");
}

/// Width of each picture of a page with one heat map alone and two side by side, px.
std::vector<double> picture_widths(const std::string& dom) {
  std::vector<double> widths;
  const std::regex width("w([0-9.]+);");
  const std::size_t at = dom.find("data-widths=\"");
  const std::string text = dom.substr(at, dom.find('>', at) - at);
  for (std::sregex_iterator m(text.begin(), text.end(), width); m != std::sregex_iterator(); ++m) {
    widths.push_back(std::stod((*m)[1]));
  }
  return widths;
}

TEST_F(ReportInABrowser, DrawsOneHeatMapNoLargerThanEachOfTwo) {
  HeatMap map;
  map.title = "the twin";
  map.rows = {{"room 1", "K"}, {"room 2", "K"}};
  map.columns = {"0", "6", "12", "18"};
  map.values = Eigen::MatrixXd::Constant(2, 4, 0.5);
  map.full_colour = {{"K", 1.0}};
  const std::string svg = heat_map_svg(map);
  ReportInput input;
  input.title = "Maps";
  input.blocks.emplace_back(PictureRow{"one", "", {svg}});
  input.blocks.emplace_back(PictureRow{"two", "", {svg, svg}});
  std::string page = report_html(input, {});
  page.insert(page.find("</body>"),
              "<script>document.body.dataset.widths=[...document.querySelectorAll('.pictures svg')].map(e=>'w'+"
              "e.getBoundingClientRect().width+';').join('')</script>");
  std::ofstream(folder_ / "maps.html") << page;
  for (const char* window : {"1280,900", "800,900"}) {
    const std::string dom = open(folder_ / "maps.html", "--window-size=" + std::string(window) + " --dump-dom");
    const std::vector<double> widths = picture_widths(dom);
    ASSERT_EQ(widths.size(), 3u) << window;
    EXPECT_GT(widths[0], 400) << window;
    EXPECT_LT(widths[0], 1.1 * widths[1]) << "one beside nothing, in a window of " << window;
    EXPECT_LT(widths[0], 540) << "hardly larger than it is drawn, in a window of " << window;
    EXPECT_EQ(widths[1], widths[2]) << window;
  }
}

TEST_F(ReportInABrowser, PaintsAScreenshotThatIsNotBlank) {
  write_report(folder_ / "report.html", make_run_report(synthetic_run(3)));
  open(folder_ / "report.html", "--window-size=390,2400 --screenshot=" + (folder_ / "shot.png").string());
  std::error_code error;
  EXPECT_GT(std::filesystem::file_size(folder_ / "shot.png", error), 40'000u);
}

}  // namespace
}  // namespace airside::tools
