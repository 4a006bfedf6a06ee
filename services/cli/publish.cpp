#include "cli/publish.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/convert_scan.hpp"
#include "bus/lcm_log.hpp"
#include "bus/service_loop.hpp"
#include "cli/json_text.hpp"
#include "cli/model_client.hpp"
#include "cli/progress.hpp"
#include "cli/publisher.hpp"
#include "cli/source_claim.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kSilence = 30'000'000;  ///< Of every ingest: then nobody is there.

Result<ScanInput> open_input(const PublishOptions& options) {
  if (options.simulate.scans > 0) return open_simulated(options.simulate);
  if (!is_lcm_log(options.kitti.folder)) return open_kitti(options.kitti);
  LogInput log = options.log;
  log.path = options.kitti.folder;
  log.origin = options.kitti.origin;
  return open_log(log);
}

/// One run of `publish`: its input, its place in it, and what became of what was sent.
class PublishRun {
 public:
  explicit PublishRun(const PublishOptions& options) : options_(options) {}

  Status start();
  Status run();
  void print_summary() const;

 private:
  Result<std::int64_t> work(std::int64_t now);
  Status publish_next(std::int64_t now);
  bool may_publish(std::int64_t now) const;
  std::int64_t next_due() const;
  bool finished() const;
  Status check_silence(std::int64_t now) const;

  PublishOptions options_;
  ScanInput input_;
  ScanIdentity next_;  ///< The next scan to publish.
  std::int64_t resumed_at_ = 0;
  std::unique_ptr<ModelClient> client_;
  std::unique_ptr<SourceClaim> claim_;
  std::unique_ptr<Publisher> publisher_;
  Progress progress_;
  std::optional<Error> damage_;
  std::uint64_t rays_ = 0;
  std::int64_t began_ = 0, ended_ = 0;
};

Status PublishRun::start() {
  auto input = open_input(options_);
  if (!input) return pass_on(input);
  input_ = std::move(*input);
  next_.source = options_.source.empty() ? input_.name.substr(0, ScanIdentity::kMaxSourceBytes)
                                         : options_.source;
  next_.session = options_.session.value_or(input_.identity);
  auto client = ModelClient::connect(options_.url);
  if (!client) return pass_on(client);
  client_ = std::move(*client);
  auto claim = SourceClaim::take(*client_, next_.source, next_.session);
  if (!claim) return pass_on(claim);
  claim_ = std::move(*claim);
  auto durable = client_->durable_up_to(next_.source, next_.session);
  if (!durable) return pass_on(durable);
  next_.seq = resumed_at_ = *durable + 1;
  if (resumed_at_ > 0) {
    fmt::print(stderr,
               "publish: {} scans of {} are in the model already; going on from there "
               "(--session N with another number adds them again)\n",
               resumed_at_, next_.source);
  }
  auto publisher = Publisher::create(client_->bus(), options_.ingests, steady_utime());
  if (!publisher) return pass_on(publisher);
  publisher_ = std::move(*publisher);
  return {};
}

Status PublishRun::run() {
  began_ = steady_utime();
  ServiceLoop loop;
  loop.buses = {&client_->bus(), &client_->in().port()};
  loop.work = [this](std::int64_t now) { return work(now); };
  loop.finished = [this] { return finished(); };
  if (auto ended = loop.run(); !ended) return ended;
  ended_ = steady_utime();
  if (!finished()) {
    return fail(
        ErrorCode::kUnavailable,
        fmt::format("stopped with {} of {} scans durable; the same command goes on",
                    resumed_at_ + static_cast<std::int64_t>(publisher_->durable()), input_.scans));
  }
  if (damage_) return tl::unexpected<Error>(*damage_);
  if (input_.ending) return tl::unexpected<Error>(*input_.ending);
  return {};
}

/// When the next scan's turn comes, where a pace was asked for.
std::int64_t PublishRun::next_due() const {
  if (!options_.hz) return began_;
  return began_ + static_cast<std::int64_t>(static_cast<double>(next_.seq - resumed_at_) * 1e6 /
                                            *options_.hz);
}

bool PublishRun::may_publish(std::int64_t now) const {
  return next_.seq < static_cast<std::int64_t>(input_.scans) && now >= next_due() &&
         publisher_->has_room(now);
}

Result<std::int64_t> PublishRun::work(std::int64_t now) {
  const auto total = static_cast<std::int64_t>(input_.scans);
  if (may_publish(now)) {
    if (auto published = publish_next(now); !published) return pass_on(published);
  }
  if (auto pumped = publisher_->pump(now); !pumped) return pass_on(pumped);
  const auto durable_below = std::max(resumed_at_, publisher_->durable_below());
  if (auto claimed = claim_->pump(now, durable_below); !claimed) return pass_on(claimed);
  if (auto heard = check_silence(now); !heard) return pass_on(heard);
  if (progress_.due()) {
    const double seconds = static_cast<double>(now - began_) / 1e6;
    progress_.say(fmt::format("{} of {} scans durable, {:.2f} M rays/s sent",
                              resumed_at_ + static_cast<std::int64_t>(publisher_->durable()), total,
                              static_cast<double>(rays_) / 1e6 / seconds));
  }
  if (may_publish(now)) return now;
  const auto next = std::min(publisher_->next_poll(now), claim_->next_poll());
  return now < next_due() ? std::min(next, next_due()) : next;
}

Status PublishRun::publish_next(std::int64_t now) {
  auto read = input_.read(static_cast<std::size_t>(next_.seq));
  if (!read) return pass_on(read);
  if (read->damage) {
    log_error("scan {}: {}", next_.seq, read->damage->message);
    if (!damage_) damage_ = std::move(read->damage);
  }
  rays_ += read->scan.points_sensor.size();
  const double sigma = options_.sigma.value_or(read->sigma.value_or(input_.sigma));
  const double min_range = options_.min_range.value_or(read->min_range.value_or(input_.min_range));
  publisher_->publish(to_message(read->scan, next_, sigma, min_range), now);
  ++next_.seq;
  return {};
}

bool PublishRun::finished() const {
  return next_.seq >= static_cast<std::int64_t>(input_.scans) && publisher_->in_flight() == 0;
}

Status PublishRun::check_silence(std::int64_t now) const {
  const std::int64_t since = std::max(publisher_->last_heard(), began_);
  if (finished() || now - since < kSilence) return {};
  return fail(ErrorCode::kUnavailable,
              fmt::format("no ingest has answered for {} s; the same command goes on with scan {}",
                          kSilence / 1'000'000,
                          resumed_at_ + static_cast<std::int64_t>(publisher_->durable())));
}

void PublishRun::print_summary() const {
  const double seconds = static_cast<double>(ended_ - began_) / 1e6;
  const auto durable = resumed_at_ + static_cast<std::int64_t>(publisher_->durable());
  const auto [delays, most_delay] = publisher_->delay();
  const double scans = static_cast<double>(std::max<std::uint64_t>(publisher_->durable(), 1));
  const double mean_ms = static_cast<double>(delays) / 1000 / scans;
  const double most_ms = static_cast<double>(most_delay) / 1000;
  if (options_.json) {
    JsonObject json;
    json.add("source", next_.source)
        .add("session", next_.session)
        .add("scans", static_cast<std::int64_t>(input_.scans))
        .add("resumed_at", resumed_at_)
        .add("durable", durable)
        .add("rays", static_cast<std::int64_t>(rays_))
        .add("seconds", seconds)
        .add("chunks_resent", static_cast<std::int64_t>(publisher_->chunks_resent()))
        .add("moved", static_cast<std::int64_t>(publisher_->moved()))
        .add("durable_after_ms_mean", mean_ms)
        .add("durable_after_ms_most", most_ms);
    fmt::print("{}\n", json.text());
  } else {
    fmt::print("{} of {} scans of {} durable; {} rays in {:.2f} s, {:.2f} M rays/s", durable,
               input_.scans, next_.source, rays_, seconds,
               static_cast<double>(rays_) / 1e6 / std::max(seconds, 1e-6));
    if (publisher_->durable() > 0) {
      fmt::print("; a scan after {:.0f} ms on average, {:.0f} ms at most", mean_ms, most_ms);
    }
    fmt::print("\n");
  }
}

}  // namespace

Status run_publish(const PublishOptions& options) {
  PublishRun run(options);
  if (auto started = run.start(); !started) return started;
  auto ended = run.run();
  if (ended) run.print_summary();
  return ended;
}

}  // namespace voxatlas
