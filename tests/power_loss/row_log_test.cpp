#include "hal/log/row_log.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <optional>

#include "hal/text/civil_text.hpp"
#include "power_loss/write_recorder.hpp"
#include "support/test_folder.hpp"

namespace airside::hal {
namespace {

const TopologyCounts counts = counts_of<ThreeVav>();
const CivilTime start = civil_time({2021, 7, 1, 0, 0, 0});

LogRow row_at(int i) {
  LogRow row = make_log_row(counts);
  row.time = {start.seconds + std::int64_t{row_s} * i};
  for (std::size_t j = 0; j < row.value.size(); ++j) row.value[j] = j >= 3 && j < 6 ? 1.0 : (2000 + i) / 100.0;
  row.value.back() = 0;
  row.setpoint_degc = (20000 + i) / 1000.0;
  row.controller.mode = "learn";
  row.controller.fault = "none";
  return row;
}

RowLog open_log(const TestFolder& folder, const RowLogLimits& limits = {}) {
  auto log = RowLog::open(folder.c_str(), counts, limits);
  if (!log) throw std::runtime_error(describe(log.error()));
  return std::move(*log);
}

void append(RowLog& log, int from, int to) {
  for (int i = from; i < to; ++i) {
    const auto done = log.append(row_at(i));
    ASSERT_TRUE(done.has_value()) << describe(done.error());
  }
}

void expect_rows(const std::filesystem::path& folder, int from, int to) {
  const Log log = read_log(folder.string(), counts);
  ASSERT_EQ(log.rows.size(), static_cast<std::size_t>(to - from));
  for (int i = from; i < to; ++i) {
    const LogRow want = row_at(i);
    const LogRow& got = log.rows[static_cast<std::size_t>(i - from)];
    ASSERT_EQ(got.time, want.time);
    ASSERT_EQ(got.value, want.value);
    ASSERT_EQ(got.setpoint_degc, want.setpoint_degc);
  }
}

void expect_rows(const TestFolder& folder, int from, int to) { expect_rows(folder.c_str(), from, to); }

TEST(RowLog, WritesOneFileADayThatTheReaderAccepts) {
  const TestFolder folder("rows");
  RowLog log = open_log(folder);
  EXPECT_EQ(log.position(), LogPosition{});
  append(log, 0, 600);
  EXPECT_EQ(log.files(), 3u);
  EXPECT_TRUE(std::filesystem::exists(folder.file("airside-2021-07-03.csv")));
  EXPECT_EQ(log.position().day, start.day() + 2);
  EXPECT_EQ(log.position().bytes, std::filesystem::file_size(folder.file("airside-2021-07-03.csv")));
  expect_rows(folder, 0, 600);
}

TEST(RowLog, KeepsTheNewestFilesOnly) {
  const TestFolder folder("rows_bounded");
  RowLog log = open_log(folder, {.max_files = 3});
  append(log, 0, 240 * 7);
  EXPECT_EQ(log.files(), 3u);
  EXPECT_EQ(folder.image().size(), 3u);
  expect_rows(folder, 240 * 4, 240 * 7);
  // A smaller bound holds from the next start on.
  log = open_log(folder, {.max_files = 2});
  EXPECT_EQ(folder.image().size(), 2u);
}

TEST(RowLog, AFileThatACutLeftEmptyCostsNoOldOne) {
  const TestFolder folder("rows_empty");
  {
    RowLog log = open_log(folder, {.max_files = 3});
    append(log, 0, 240 * 3);
  }
  std::ofstream(folder.file("airside-2021-07-04.csv")).flush();
  const RowLog log = open_log(folder, {.max_files = 3});
  EXPECT_EQ(log.files(), 3u);
  expect_rows(folder, 0, 240 * 3);
}

TEST(RowLog, AnOldFileThatSomebodyElseRemovedIsGone) {
  const TestFolder folder("rows_gone");
  RowLog log = open_log(folder, {.max_files = 2});
  append(log, 0, 240 * 2);
  std::filesystem::remove(folder.file("airside-2021-07-01.csv"));
  append(log, 240 * 2, 240 * 3);
  EXPECT_TRUE(log.sync());
  expect_rows(folder, 240, 240 * 3);
}

TEST(RowLog, StartsAFurtherFileWhenADaysFileIsFull) {
  const TestFolder folder("rows_parts");
  RowLog log = open_log(folder, {.max_files = 50, .max_file_bytes = 4000});
  append(log, 0, 300);
  EXPECT_GT(log.files(), 6u);
  EXPECT_TRUE(std::filesystem::exists(folder.file("airside-2021-07-01_03.csv")));
  for (const auto& [name, bytes] : folder.image()) EXPECT_LE(bytes.size(), 4000u) << name;
  expect_rows(folder, 0, 300);
  const LogPosition end = log.position();
  log = open_log(folder, {.max_files = 50, .max_file_bytes = 4000});
  EXPECT_EQ(log.position(), end);
}

TEST(RowLog, ResumeCutsUncommittedRowsAndGoesOnWithoutLossOrDouble) {
  for (const int committed : {1, 100, 239, 240, 241, 480}) {
    for (const int beyond : {0, 1, 5, 300}) {
      const TestFolder folder("rows_resume");
      LogPosition position;
      {
        RowLog log = open_log(folder);
        append(log, 0, committed);
        position = log.position();
        append(log, committed, committed + beyond);
      }
      RowLog log = open_log(folder);
      ASSERT_TRUE(log.resume(position).has_value());
      ASSERT_EQ(log.position(), position);
      ASSERT_EQ(log.last_time(), row_at(committed - 1).time);
      append(log, committed, committed + 10);
      expect_rows(folder, 0, committed + 10);
    }
  }
}

TEST(RowLog, Row34CutAtEveryByteOfARowIsTheLogBeforeOrAfterIt) {
  const TestFolder folder("rows_cut");
  for (const int committed : {3, 240}) {  // the second starts a new file, with its header
    folder.restore({});
    LogPosition position;
    FolderImage before;
    std::vector<WriteOp> ops;
    {
      RowLog log = open_log(folder);
      append(log, 0, committed);
      position = log.position();
      before = folder.image();
      WriteRecorder recorder;
      append(log, committed, committed + 1);
      ops = recorder.ops;
    }
    const FolderImage after = folder.image();
    int states = 0;
    for (const auto& [name, bytes] : after) {
      const std::size_t old_size = before.count(name) != 0 ? before.at(name).size() : 0;
      for (std::size_t size = old_size; size < bytes.size(); ++size) {
        FolderImage torn = before;
        torn[name].assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        // Without a committed position: an unfinished row goes.
        folder.restore(torn);
        {
          RowLog log = open_log(folder);
          ASSERT_EQ(log.position(), position) << size;
          append(log, committed, committed + 2);
        }
        expect_rows(folder, 0, committed + 2);
        // With one: whatever stands there after it goes.
        folder.restore(torn);
        {
          RowLog log = open_log(folder);
          ASSERT_TRUE(log.resume(position).has_value()) << size;
          append(log, committed, committed + 2);
        }
        expect_rows(folder, 0, committed + 2);
        if (HasFatalFailure()) FAIL() << name << " cut at " << size;
        ++states;
      }
    }
    EXPECT_GT(states, 80);
    EXPECT_FALSE(ops.empty());
  }
}

TEST(RowLog, ARowThatCannotBeWrittenLeavesNoTraceAndTheNextOneFits) {
  const TestFolder folder("rows_fail");
  RowLog log = open_log(folder);
  append(log, 0, 5);
  const FolderImage before = folder.image();
  {
    WriteRecorder recorder;
    recorder.fail_at = 0;
    recorder.fail_errno = ENOSPC;
    const auto done = log.append(row_at(5));
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().fault, StoreFault::no_space);
  }
  EXPECT_EQ(folder.image(), before);
  {
    WriteRecorder recorder;  // not even the half row can be cut off
    recorder.fail_at = 0;
    recorder.fail_count = 2;
    recorder.fail_errno = EIO;
    EXPECT_EQ(log.append(row_at(5)).error().fault, StoreFault::io);
  }
  append(log, 5, 7);
  expect_rows(folder, 0, 7);
}

TEST(RowLog, Row33AFailedSyncIsReportedAndItsRowsAreWrittenAgain) {
  const TestFolder folder("rows_sync");
  RowLog log = open_log(folder);
  append(log, 0, 2);
  ASSERT_TRUE(log.sync().has_value());
  const std::uint64_t synced = log.position().bytes;
  append(log, 2, 4);
  WriteRecorder recorder;
  recorder.fail_at = 0;
  recorder.fail_errno = EIO;
  const auto done = log.sync();
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().fault, StoreFault::io);
  recorder.ops.clear();
  ASSERT_TRUE(log.sync().has_value());
  ASSERT_EQ(recorder.ops.size(), 2u);
  EXPECT_EQ(recorder.ops[0].kind, WriteOp::Kind::write);
  EXPECT_EQ(recorder.ops[0].offset, synced);
  EXPECT_EQ(synced + recorder.ops[0].bytes.size(), log.position().bytes);
  EXPECT_EQ(recorder.ops[1].kind, WriteOp::Kind::sync);
  expect_rows(folder, 0, 4);
}

TEST(RowLog, RowsThatAreNotAfterTheLastOneAreRefused) {
  const TestFolder folder("rows_order");
  {
    RowLog log = open_log(folder);
    append(log, 0, 5);
  }
  RowLog log = open_log(folder);
  for (const int i : {0, 3, 4}) {
    const auto done = log.append(row_at(i));
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().fault, StoreFault::out_of_order);
  }
  // Nothing was committed: nothing is removed, and no row stands twice.
  ASSERT_TRUE(log.resume({}).has_value());
  EXPECT_EQ(log.append(row_at(4)).error().fault, StoreFault::out_of_order);
  append(log, 5, 6);
  expect_rows(folder, 0, 6);
}

TEST(RowLog, CommittedRowsThatAreMissingAreReported) {
  const TestFolder folder("rows_lost");
  LogPosition position;
  {
    RowLog log = open_log(folder);
    append(log, 0, 10);
    position = log.position();
  }
  const auto path = folder.file("airside-2021-07-01.csv");
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 30);
  {
    RowLog log = open_log(folder);
    const auto done = log.resume(position);
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().fault, StoreFault::log_shorter);
    EXPECT_EQ(log.last_time(), row_at(8).time);
    append(log, 10, 12);
  }
  EXPECT_EQ(read_log(folder.c_str(), counts).summary.missing_rows, 1u);
  std::filesystem::remove(path);
  RowLog log = open_log(folder);
  EXPECT_EQ(log.resume(position).error().fault, StoreFault::log_shorter);
}

TEST(RowLog, AnotherTopologysFileIsNotAppendedTo) {
  const TestFolder folder("rows_other");
  {
    RowLog log = open_log(folder);
    append(log, 0, 5);
  }
  const TopologyCounts five = counts_of<FiveZone>();
  auto log = RowLog::open(folder.c_str(), five);
  ASSERT_TRUE(log.has_value());
  LogRow row = make_log_row(five);
  row.time = row_at(5).time;
  ASSERT_TRUE(log->append(row).has_value());
  EXPECT_EQ(log->files(), 2u);
  EXPECT_EQ(log->position().part, 1u);
  EXPECT_EQ(read_log(folder.file("airside-2021-07-01.csv").string(), counts).rows.size(), 5u);
}

TEST(RowLog, ForeignFilesAreLeftAlone) {
  const TestFolder folder("rows_foreign");
  for (const char* name : {"notes.txt", "airside-2021-07-01.csv.bak", "airside-2021-13-01.csv",
                           "airside-2021-07-01_0.csv", "airside-2021-07-01-00.csv", "airside-2021-07-01xy.csv"}) {
    std::ofstream(folder.file(name)) << "mine\n";
  }
  RowLog log = open_log(folder, {.max_files = 2});
  EXPECT_EQ(log.files(), 0u);
  append(log, 0, 240 * 5);
  EXPECT_EQ(folder.image().size(), 6u + 2u);
}

TEST(RowLog, NamesThatOnlyLookLikeItsOwnAreForeign) {
  const TestFolder folder("rows_names");
  for (const char* name : {"airside-2021-07-01_00.csv", "airside-2021-07-01_zz.csv", "airside-2021-07-01-01.csv"}) {
    std::ofstream(folder.file(name)) << "mine\n";
  }
  RowLog log = open_log(folder);
  EXPECT_EQ(log.files(), 0u);
  append(log, 0, 3);
  EXPECT_EQ(folder.image().size(), 4u);
}

TEST(RowLog, AFileOfOneEmptyLineHoldsNoRow) {
  const TestFolder folder("rows_line");
  std::ofstream(folder.file("airside-2021-07-01.csv")) << "\n";
  RowLog log = open_log(folder);
  EXPECT_EQ(log.position(), LogPosition{});
  append(log, 0, 3);
  expect_rows(folder, 0, 3);
}

TEST(RowLog, ARowTooLongForALineIsRefusedAndTheNextOneFits) {
  const TestFolder folder("rows_long");
  RowLog log = open_log(folder);
  LogRow row = row_at(0);
  row.controller.mode = std::string(max_log_row_text, 'x');
  EXPECT_EQ(log.append(row).error().fault, StoreFault::row_too_long);
  append(log, 0, 2);
  expect_rows(folder, 0, 2);
}

TEST(RowLog, ADayOfMoreThanAHundredPartsGoesOnInTheLast) {
  const TestFolder folder("rows_many");
  RowLog log = open_log(folder, {.max_files = 200, .max_file_bytes = 1});
  append(log, 0, 120);
  EXPECT_EQ(log.files(), 100u);
  expect_rows(folder, 0, 120);
}

TEST(RowLog, AFileWhoseFirstRowFailedIsUsedForTheNext) {
  const TestFolder folder("rows_first");
  const RowLogLimits limits{.max_files = 10, .max_file_bytes = 1};
  RowLog log = open_log(folder, limits);
  {
    WriteRecorder recorder;
    recorder.fail_at = 1;  // behind the truncation of the new file
    recorder.fail_errno = ENOSPC;
    EXPECT_EQ(log.append(row_at(0)).error().fault, StoreFault::no_space);
  }
  append(log, 0, 1);
  EXPECT_EQ(folder.image().size(), 1u);
  expect_rows(folder, 0, 1);
}

TEST(RowLog, RowsInDoubtThatSomebodyCutOffAreNotWaitedFor) {
  const TestFolder folder("rows_shrunk");
  RowLog log = open_log(folder);
  append(log, 0, 3);
  {
    WriteRecorder recorder;
    recorder.fail_at = 0;
    recorder.fail_errno = EIO;
    ASSERT_FALSE(log.sync());
  }
  std::filesystem::resize_file(folder.file("airside-2021-07-01.csv"), 0);
  EXPECT_TRUE(log.sync()) << "what is gone cannot be written again";
}

/// A log of five rows whose files somebody takes away while it is in use.
class TakenLog : public ::testing::Test {
 protected:
  TakenLog() {
    append(log, 0, 5);
    EXPECT_TRUE(log.sync());
    before = log.position();
  }
  ~TakenLog() override { std::filesystem::remove_all(away); }
  void move_away() const { std::filesystem::rename(folder.c_str(), away); }
  void replace() const {
    move_away();
    std::filesystem::create_directory(folder.c_str());
  }
  void put_back() const { std::filesystem::copy(away, folder.c_str()); }
  /// Appends rows of which the first is told to be in other files than those before.
  void append_elsewhere(int from, int to) {
    append(log, from, from + 1);
    const auto done = log.sync();
    ASSERT_FALSE(done) << "not in silence";
    EXPECT_EQ(done.error().fault, StoreFault::removed);
    append(log, from + 1, to);
    EXPECT_TRUE(log.sync()) << "told once";
  }

  TestFolder folder{"rows_taken"};
  const std::string away = std::string(folder.c_str()) + ".old";
  RowLog log = open_log(folder);
  LogPosition before;
};

TEST_F(TakenLog, GoesOnInTheFolderThatStandsThere) {
  replace();
  append_elsewhere(5, 8);
  expect_rows(std::filesystem::path(away), 0, 5);
  expect_rows(folder, 5, 8);
  const LogPosition end = log.position();
  EXPECT_EQ(end.bytes, std::filesystem::file_size(folder.file("airside-2021-07-01_01.csv")));
  append(log, 8, 10);
  log = open_log(folder);
  ASSERT_TRUE(log.resume(end)) << "a start cuts here what was not committed, no more";
  append(log, 8, 250);
  expect_rows(folder, 5, 250);
}

TEST_F(TakenLog, GoesOnInAFolderThatIsMadeWhereNoneStands) {
  std::filesystem::remove_all(folder.c_str());
  append_elsewhere(5, 8);
  expect_rows(folder, 5, 8);
}

TEST_F(TakenLog, StandsBesideItsOldFilesWhereTheyArePutBack) {
  replace();
  append_elsewhere(5, 40);
  put_back();
  log = open_log(folder);
  expect_rows(folder, 0, 40);
  // The commit that named the new file did not come to be: the old one's end is where the log goes on.
  ASSERT_TRUE(log.resume(before));
  append(log, 5, 7);
  expect_rows(folder, 0, 7);
}

TEST_F(TakenLog, AStartThatKnowsTheOldFileAloneTellsThatItsRowsAreMissing) {
  replace();
  append_elsewhere(5, 6);
  log = open_log(folder);
  EXPECT_EQ(log.resume(before).error().fault, StoreFault::log_shorter);
  append(log, 5, 8);
  expect_rows(folder, 5, 8);
}

TEST_F(TakenLog, KeepsTheRowsOfACopyThatWasPutInItsPlace) {
  log = open_log(folder);
  ASSERT_TRUE(log.resume(before));
  append(log, 5, 250);
  move_away();
  put_back();
  append_elsewhere(250, 260);
  expect_rows(folder, 0, 260);
}

TEST_F(TakenLog, RefusesRowsThatAreNotBehindThoseOfTheOtherFolder) {
  replace();
  {
    const TestFolder other("rows_ahead");
    RowLog ahead = open_log(other);
    append(ahead, 300, 303);
    std::filesystem::copy(other.c_str(), folder.c_str());
  }
  EXPECT_EQ(log.append(row_at(5)).error().fault, StoreFault::out_of_order);
  append(log, 303, 305);
  expect_rows(folder, 300, 305);
}

TEST_F(TakenLog, AFileThatWasRemovedIsFollowedByAFurtherOne) {
  std::filesystem::remove(folder.file("airside-2021-07-01.csv"));
  append_elsewhere(5, 8);
  expect_rows(folder, 5, 8);
  std::filesystem::remove(folder.file("airside-2021-07-01_01.csv"));
  append_elsewhere(8, 300);
  expect_rows(folder, 8, 300);
  EXPECT_TRUE(std::filesystem::exists(folder.file("airside-2021-07-01_02.csv")));
  EXPECT_TRUE(std::filesystem::exists(folder.file("airside-2021-07-02.csv"))) << "a new day's first file as ever";
}

TEST_F(TakenLog, TellsWhyItHasNoFolderUntilThereIsOne) {
  move_away();
  std::ofstream(folder.c_str()).put('x');
  for (int i = 5; i < 7; ++i) EXPECT_EQ(log.append(row_at(i)).error().fault, StoreFault::not_found);
  EXPECT_EQ(log.position(), before) << "what a commit may name: it stands in the old folder";
  std::filesystem::remove(folder.c_str());
  std::filesystem::rename(away, folder.c_str());
  append_elsewhere(7, 10);
  EXPECT_EQ(read_log(folder.c_str(), counts).summary.missing_rows, 2u);
}

TEST_F(TakenLog, WithoutARowYetBeginsInTheFolderThatStandsThere) {
  const TestFolder empty("rows_taken_empty");
  RowLog none = open_log(empty);
  std::filesystem::remove_all(empty.c_str());
  append(none, 0, 2);
  EXPECT_EQ(none.sync().error().fault, StoreFault::removed);
  EXPECT_EQ(none.position().part, 0u);
  expect_rows(empty, 0, 2);
}

TEST_F(TakenLog, AFolderThatStaysIsNotTakenForAnother) {
  append(log, 5, 250);
  std::filesystem::permissions(folder.c_str(), std::filesystem::perms::group_write, std::filesystem::perm_options::add);
  std::ofstream(folder.file("note")).put('x');
  std::filesystem::remove(folder.file("airside-2021-07-01.csv"));
  append(log, 250, 260);
  EXPECT_TRUE(log.sync()) << "an old file may go";
  EXPECT_EQ(log.position().part, 0u);
  EXPECT_EQ(folder.image().size(), 2u);
}

/// A log whose folder was taken by a file while it was opened.
class LateLog : public ::testing::Test {
 protected:
  LateLog() {
    RowLog log = open_log(there);
    append(log, 0, 240);
    first_day = log.position();
    append(log, 240, 245);
    std::ofstream(folder.file("log")).put('x');
    late.emplace(folder.file("log").c_str(), counts);
    EXPECT_FALSE(late->ready());
  }
  /// The folder is there now, as `there` is.
  void bring() const {
    std::filesystem::remove(folder.file("log"));
    std::filesystem::copy(there.c_str(), folder.file("log"));
  }

  TestFolder there{"rows_there"}, folder{"rows_late"};
  LogPosition first_day;
  std::optional<RowLog> late;
};

TEST_F(LateLog, ResumesWhereItWasToldBeforeItAppends) {
  EXPECT_FALSE(late->resume(first_day));
  EXPECT_FALSE(late->append(row_at(240)));
  bring();
  append(*late, 240, 243);
  expect_rows(folder.file("log"), 0, 243);
}

TEST_F(LateLog, GoesOnBehindTheLastWholeRowWhereCommittedOnesAreMissing) {
  LogPosition beyond = first_day;
  beyond.bytes += 10'000;
  EXPECT_FALSE(late->resume(beyond));
  bring();
  append(*late, 240, 243);
  expect_rows(folder.file("log"), 0, 243);
}

TEST_F(LateLog, ResumesInTheFolderThatCameInPlaceOfOneThatIsOfNoUse) {
  std::filesystem::remove(folder.file("log"));
  std::filesystem::create_directories(folder.file("log") / "airside-2021-07-01.csv");
  late.emplace(folder.file("log").c_str(), counts);
  EXPECT_FALSE(late->resume(first_day));
  EXPECT_FALSE(late->append(row_at(240)));
  std::filesystem::rename(folder.file("log"), folder.file("useless"));
  std::filesystem::copy(there.c_str(), folder.file("log"));
  append(*late, 240, 243);
  expect_rows(folder.file("log"), 0, 243);
}

TEST_F(LateLog, AppendsNothingWhereItCannotResume) {
  EXPECT_FALSE(late->resume(first_day));
  bring();
  const auto file = folder.file("log") / "airside-2021-07-01.csv";
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  const auto done = late->append(row_at(250));
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, StoreFault::wrong_kind) << describe(done.error());
}

}  // namespace
}  // namespace airside::hal
