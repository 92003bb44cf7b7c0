#include "wire/check.h"
#include "wire/parts.h"
#include "wire/wire.h"

namespace primo::wire {

msg::JudgeSettings to_wire(const physics::JudgeSettings& settings) {
  msg::JudgeSettings out;
  out.timestep(settings.timestep);
  out.close_seconds(settings.close_seconds);
  out.jiggle_seconds(settings.jiggle_seconds);
  out.jiggle_frequency(settings.jiggle_frequency);
  out.jiggle_translation(settings.jiggle_translation);
  out.jiggle_rotation(settings.jiggle_rotation);
  out.max_displacement(settings.max_displacement);
  out.max_penetration(settings.max_penetration);
  out.clearance_margin(settings.clearance_margin);
  out.target_margin(settings.target_margin);
  out.max_joint_speed(settings.max_joint_speed);
  out.limit_margin(settings.limit_margin);
  out.place_criterion(static_cast<std::uint8_t>(settings.place_criterion));
  out.place_height(settings.place_height);
  out.place_offset(settings.place_offset);
  out.place_tilt(settings.place_tilt);
  out.place_speed(settings.place_speed);
  out.survival_amplitudes(settings.survival_amplitudes);
  out.survival_seeds(settings.survival_seeds);
  return out;
}

Result<physics::JudgeSettings> from_wire(const msg::JudgeSettings& message) {
  physics::JudgeSettings out;
  out.timestep = message.timestep();
  out.close_seconds = message.close_seconds();
  out.jiggle_seconds = message.jiggle_seconds();
  out.jiggle_frequency = message.jiggle_frequency();
  out.jiggle_translation = message.jiggle_translation();
  out.jiggle_rotation = message.jiggle_rotation();
  out.max_displacement = message.max_displacement();
  out.max_penetration = message.max_penetration();
  out.clearance_margin = message.clearance_margin();
  out.target_margin = message.target_margin();
  out.max_joint_speed = message.max_joint_speed();
  out.limit_margin = message.limit_margin();
  PRIMO_ASSIGN(out.place_criterion, enum_from<physics::PlaceCriterion>("place_criterion", message.place_criterion()));
  out.place_height = message.place_height();
  out.place_offset = message.place_offset();
  out.place_tilt = message.place_tilt();
  out.place_speed = message.place_speed();
  out.survival_amplitudes = message.survival_amplitudes();
  out.survival_seeds = message.survival_seeds();
  PRIMO_TRY(check_fields("settings", out));
  return out;
}

msg::JudgeRequest to_wire(const physics::JudgeRequest& request) {
  msg::JudgeRequest out;
  out.scenario(to_wire(request.scenario));
  out.q(to_wire(request.q));
  out.dt(request.dt);
  out.planner_iterations(request.planner_iterations);
  out.feedback(to_wire(request.K));
  out.seed(request.seed);
  out.mode(static_cast<std::uint8_t>(request.mode));
  out.settings(to_wire(request.settings));
  return out;
}

Result<physics::JudgeRequest> from_wire(const msg::JudgeRequest& message) {
  physics::JudgeRequest out;
  PRIMO_ASSIGN(out.scenario, from_wire(message.scenario()));
  PRIMO_ASSIGN(out.q, from_wire("q", message.q()));
  PRIMO_TRY(check_finite("dt", message.dt()));
  out.dt = message.dt();
  out.planner_iterations = message.planner_iterations();
  PRIMO_ASSIGN(out.K, from_wire("feedback", message.feedback()));
  out.seed = message.seed();
  PRIMO_ASSIGN(out.mode, enum_from<physics::Mode>("mode", message.mode()));
  PRIMO_ASSIGN(out.settings, from_wire(message.settings()));
  return out;
}

namespace {

msg::Survival to_wire(const physics::Survival& row) {
  msg::Survival out;
  out.amplitude(row.amplitude);
  out.seeds(row.seeds);
  out.held(row.held);
  out.survival(row.survival);
  out.displacement(row.displacement);
  return out;
}

msg::Contact to_wire(const physics::Contact& contact) {
  msg::Contact out;
  out.first(contact.first);
  out.second(contact.second);
  out.begin(contact.begin);
  out.end(contact.end);
  out.peak_force(contact.peak_force);
  return out;
}

/// The lists of a verdict that say more than its numbers do.
Status read_details(const msg::Verdict& message, physics::Verdict& out) {
  PRIMO_TRY(check_count("verdict.survivals", message.survivals().size()));
  for (const msg::Survival& row : message.survivals()) {
    PRIMO_TRY(
        check_finite("verdict.survivals", std::vector<double>{row.amplitude(), row.survival(), row.displacement()}));
    if (row.seeds() < 0 || row.held() < 0 || row.held() > row.seeds())
      return malformed("verdict.survivals", "holds more often than it was shaken");
    out.survivals.push_back({row.amplitude(), row.seeds(), row.held(), row.survival(), row.displacement()});
  }
  PRIMO_TRY(check_count("verdict.contacts", message.contacts().size(), physics::Verdict::kMostContacts));
  for (const msg::Contact& contact : message.contacts()) {
    PRIMO_TRY(check_texts("verdict.contacts", {contact.first(), contact.second()}));
    PRIMO_TRY(
        check_finite("verdict.contacts", std::vector<double>{contact.begin(), contact.end(), contact.peak_force()}));
    out.contacts.push_back({contact.first(), contact.second(), contact.begin(), contact.end(), contact.peak_force()});
  }
  out.unlisted_contacts = message.unlisted_contacts();
  return success();
}

}  // namespace

msg::Verdict to_wire(const physics::Verdict& verdict) {
  msg::Verdict out;
  out.success(verdict.success);
  out.final_pose_success(verdict.final_pose_success);
  out.path_clean(verdict.path_clean);
  out.outcome(static_cast<std::uint8_t>(verdict.outcome));
  out.reason(verdict.reason);
  out.score(verdict.score);
  out.displacement(verdict.displacement);
  out.survival(verdict.survival);
  out.position_error(verdict.position_error);
  out.clearance(verdict.clearance);
  out.target_clearance(verdict.target_clearance);
  out.limit_margin(verdict.limit_margin);
  out.max_speed(verdict.max_speed);
  out.path_length(verdict.path_length);
  for (const physics::Criterion& criterion : verdict.criteria) {
    msg::Criterion entry;
    entry.name(criterion.name);
    entry.value(criterion.value);
    entry.margin(criterion.margin);
    entry.met(criterion.met);
    out.criteria().push_back(std::move(entry));
  }
  out.before(to_wire(verdict.before));
  out.after(to_wire(verdict.after));
  out.objects(verdict.objects);
  out.steps(verdict.steps);
  for (const auto& row : verdict.survivals) out.survivals().push_back(to_wire(row));
  for (const auto& contact : verdict.contacts) out.contacts().push_back(to_wire(contact));
  out.unlisted_contacts(verdict.unlisted_contacts);
  return out;
}

Result<physics::Verdict> from_wire(const msg::Verdict& message) {
  physics::Verdict out;
  out.success = message.success();
  out.final_pose_success = message.final_pose_success();
  out.path_clean = message.path_clean();
  PRIMO_ASSIGN(out.outcome, enum_from<physics::Outcome>("verdict.outcome", message.outcome()));
  PRIMO_TRY(check_text("verdict.reason", message.reason()));
  out.reason = message.reason();
  PRIMO_TRY(check_finite("verdict",
                         std::vector<double>{message.score(), message.displacement(), message.survival(),
                                             message.position_error(), message.clearance(), message.target_clearance(),
                                             message.limit_margin(), message.max_speed(), message.path_length()}));
  out.score = message.score();
  out.displacement = message.displacement();
  out.survival = message.survival();
  out.position_error = message.position_error();
  out.clearance = message.clearance();
  out.target_clearance = message.target_clearance();
  out.limit_margin = message.limit_margin();
  out.max_speed = message.max_speed();
  out.path_length = message.path_length();
  PRIMO_TRY(check_count("verdict.criteria", message.criteria().size()));
  for (const msg::Criterion& entry : message.criteria()) {
    PRIMO_TRY(check_text("verdict.criteria", entry.name()));
    PRIMO_TRY(check_finite("verdict.criteria", std::vector<double>{entry.value(), entry.margin()}));
    out.criteria.push_back({entry.name(), entry.value(), entry.margin(), entry.met()});
  }
  PRIMO_ASSIGN(out.before, state_from_wire("verdict.before", message.before()));
  PRIMO_ASSIGN(out.after, state_from_wire("verdict.after", message.after()));
  PRIMO_TRY(check_texts("verdict.objects", message.objects()));
  out.objects = message.objects();
  out.steps = message.steps();
  PRIMO_TRY(read_details(message, out));
  return out;
}

}  // namespace primo::wire
