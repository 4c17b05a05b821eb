#include "firmware/page/answers.hpp"

#include <fmt/format.h>
#include <microhttpd.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "firmware/page/data/facts.hpp"
#include "firmware/page/data/metrics.hpp"
#include "firmware/page/data/trends.hpp"
#include "firmware/page/http/response.hpp"

namespace airside::page {
namespace {

constexpr std::uint64_t max_weights_bytes = 4u << 20;

/// Rows that are still to be sent. They may be overwritten meanwhile; those are left out.
struct CsvStream {
  const TrendStore* store;
  std::uint64_t next, end;
  std::string text;
  std::size_t sent = 0;
};

ssize_t send_rows(void* self, std::uint64_t, char* out, std::size_t most) {
  auto& stream = *static_cast<CsvStream*>(self);
  if (stream.sent == stream.text.size()) {
    stream.text.clear();
    stream.sent = 0;
    stream.next = std::max(stream.next, stream.store->first());
    // The log may have begun anew since.
    for (const std::uint64_t end = std::min(stream.end, stream.store->count());
         stream.next < end && stream.text.size() < most;) {
      append_csv_row(*stream.store, stream.next++, stream.text);
    }
    if (stream.text.empty()) return MHD_CONTENT_READER_END_OF_STREAM;
  }
  const std::size_t n = std::min(most, stream.text.size() - stream.sent);
  std::copy_n(stream.text.begin() + static_cast<std::ptrdiff_t>(stream.sent), n, out);
  stream.sent += n;
  return static_cast<ssize_t>(n);
}

Answer json_answer(const nlohmann::json& value) { return {MHD_HTTP_OK, response_of(without_markup(dumped(value)))}; }

Answer typed(MHD_Response* response, const char* type) {
  if (response != nullptr) MHD_add_response_header(response, "Content-Type", type);
  return {MHD_HTTP_OK, response};
}

Answer csv_of(MHD_Response* response, const char* name) {
  if (response != nullptr) {
    MHD_add_response_header(response, "Content-Disposition", fmt::format("attachment; filename=\"{}\"", name).c_str());
  }
  return typed(response, "text/csv; charset=utf-8");
}

}  // namespace

Answers::Answers(const hal::SiteFile& site)
    : state_dir_(site.state_dir),
      site_text_(without_markup(dumped(site_facts(site)))),
      of_band_(site.objective == Objective::band),
      plant_clock_(site.clock == hal::ClockSource::plant),
      gap_hint_(site),
      status_(site.state_dir),
      ledger_(site.page.dir),
      checkout_(site),
      store_(site) {}

bool Answers::tick(std::int64_t now_ns) {
  constexpr std::int64_t pause_ns = 200'000'000;
  if (!more_ && now_ns - looked_ns_ < pause_ns) return false;
  looked_ns_ = now_ns;
  if (status_.refresh()) {
    ledger_.watch(status_.object());
    more_ = true;  // the row of this status is in the log already
  }
  if (more_) more_ = store_.step();
  return more_;
}

Answer Answers::read(Route route, const char* span) {
  const std::string_view asked = span == nullptr ? "day" : span;
  switch (route) {
    case Route::status: return status();
    case Route::site: return {MHD_HTTP_OK, response_of(site_text_)};
    case Route::alarms: return json_answer(ledger_.alarms());
    case Route::weights_facts:
      return json_answer({{"given_out", given_out_facts(state_dir_)}, {"events", ledger_.events()}});
    case Route::trends: return trends_json(asked);
    case Route::trends_csv: return trends_csv(asked);
    case Route::gap: return gap();
    case Route::points: return json_answer(checkout_.points());
    case Route::points_csv: return csv_of(response_of(checkout_.csv()), "points.csv");
    case Route::metrics:
      status_.refresh();
      return typed(response_of(metrics_text(status_)), "text/plain; version=0.0.4; charset=utf-8");
    case Route::weights: return weights();
    default: return {404, json_of(refusal(404, refusals::no_page))};  // uncovered: the server asks for no other
  }
}

Answer Answers::status() {
  if (status_.refresh()) {
    ledger_.watch(status_.object());
    more_ = true;
  }
  if (status_.text().empty()) return {503, json_of(refusal(503, refusals::no_status))};
  MHD_Response* response = response_of(without_markup(status_.text()));
  // The status has the site's clock, which nobody can compare with a browser's. Age knows no file from the future, as
  // a box without a battery for its clock leaves behind; it must not pass for a new one.
  if (response != nullptr) {
    const double age_s = status_.age_s();
    MHD_add_response_header(response, "Age", fmt::format("{:.0f}", std::abs(age_s)).c_str());
    if (age_s <= -1) MHD_add_response_header(response, "X-Airside-Ahead", fmt::format("{:.0f}", -age_s).c_str());
  }
  return {MHD_HTTP_OK, response};
}

Answer Answers::weights() const {
  std::uint64_t size = 0;
  hal::StorageFile file = open_in(state_dir_, "weights.blob", max_weights_bytes, size);
  if (!file.is_open() || size == 0) {
    return {404, json_of(refusal(404, refusals::no_weights))};
  }
  MHD_Response* response = MHD_create_response_from_fd(static_cast<std::size_t>(size), ::dup(file.descriptor()));
  if (response != nullptr) {
    MHD_add_response_header(response, "Content-Disposition", "attachment; filename=\"weights.blob\"");
  }
  return typed(response, "application/octet-stream");
}

bool Answers::is_of_now(const Cached& cached) const {
  return !cached.text.empty() && cached.generation == store_.generation() && cached.count == store_.count() &&
         cached.reading == store_.is_reading();
}

Answer Answers::trends_json(std::string_view span) {
  if (!rows_of_span(span)) return {400, json_of(refusal(400, refusals::span_unknown))};
  Cached& cached = cached_[span == "day" ? 0 : span == "week" ? 1 : 2];
  if (!is_of_now(cached)) {
    cached = {store_.generation(), store_.count(), store_.is_reading(),
              without_markup(dumped(trends(store_, span, of_band_)))};
  }
  return {MHD_HTTP_OK, response_of(cached.text)};
}

Answer Answers::gap() {
  if (!is_of_now(gap_)) {
    nlohmann::json gap = forecast_gap(store_);
    gap["commands"] = gap_hint_.commands(gap["reference_days"].get<int>());
    gap_ = {store_.generation(), store_.count(), store_.is_reading(), without_markup(dumped(gap))};
  }
  return {MHD_HTTP_OK, response_of(gap_.text)};
}

Answer Answers::trends_csv(std::string_view span) const {
  const auto rows = rows_of_span(span);
  if (!rows) return {400, json_of(refusal(400, refusals::span_unknown))};
  const std::uint64_t end = store_.count();
  const CivilTime last = end == 0 ? CivilTime{} : store_.row(end - 1).time;
  const std::uint64_t from =
      end == 0 ? 0 : store_.from({last.seconds - static_cast<std::int64_t>(*rows) * row_s + row_s});
  auto* stream = new CsvStream{&store_, from, end, trends_csv_header(store_)};  // the library ends it
  const auto free_stream = [](void* self) { delete static_cast<CsvStream*>(self); };
  MHD_Response* response = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 16384, &send_rows, stream, free_stream);
  if (response == nullptr) {
    free_stream(stream);
    return {};
  }
  return csv_of(response, "trends.csv");
}

}  // namespace airside::page
