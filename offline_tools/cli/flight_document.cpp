#include "cli/flight_document.hpp"

#include "cli/plan_document.hpp"

namespace swiftlet::tools {
namespace {

Json to_json(const Vector3& v) { return Json::array({v[0], v[1], v[2]}); }
Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

const char* to_word(SetpointForm form) {
  switch (form) {
    case SetpointForm::kPosition:
      return "position";
    case SetpointForm::kAttitude:
      return "attitude";
    case SetpointForm::kRates:
      return "rates";
  }
  return "none";
}

Json request_json(const FlightRequest& request) {
  Json goals = Json::array();
  for (const Vector3& goal : request.goals) goals.push_back(to_json(goal));
  Json faults = Json::array();
  for (const FlightFault& fault : request.faults) {
    faults.push_back({{"kind", describe(fault)}, {"at", begin_of(fault)}});
  }
  const FlightLimits& limits = request.companion.limits;
  return {{"start", to_json(request.start)},
          {"yaw", request.yaw},
          {"goals", std::move(goals)},
          {"setpoint", to_word(request.companion.form)},
          {"vmax", limits.v_max},
          {"amax", limits.a_max},
          {"jmax", limits.j_max < kUnlimited ? Json(limits.j_max) : Json(nullptr)},
          {"wind", to_json(request.sim.simulation.wind.mean)},
          {"gust", request.sim.simulation.wind.gust},
          {"heading_noise", request.sim.simulation.estimator.attitude_sigma.z()},
          {"link_delay", std::chrono::duration<double>(request.sim.link_delay).count()},
          {"faults", std::move(faults)},
          {"seed", request.sim.simulation.seed},
          {"in_process", request.in_process}};
}

Json margins_json(const FlightRequest& request, const MapFile& map) {
  const companion::Margins& margins = request.companion.margins;
  return {{"map_radius", map.graph.header().radius}, {"vehicle_radius", margins.vehicle_radius},
          {"map_error", margins.map_error},          {"tracking_tube", tube_of(margins.tubes, request.companion.form)},
          {"numeric", margins.numeric_margin},       {"heading_accuracy", margins.heading_accuracy}};
}

Json link_json(const FlightReport& report) {
  return {{"messages_in", report.codec.frames},
          {"messages_out", report.link.sent_frames},
          {"crc_errors", report.codec.bad_checksum},
          {"bytes_in", report.link.received_bytes},
          {"bytes_out", report.link.sent_bytes},
          {"lost", report.link.lost_frames},
          {"unsent", report.link.unsent_frames},
          {"load_in", report.load_in},
          {"load_out", report.load_out}};
}

Json setpoints_json(const SetpointReport& setpoints) {
  return {{"count", setpoints.count},
          {"stale", setpoints.stale},
          {"repeated", setpoints.repeated},
          {"interval_p50", setpoints.interval_p50},
          {"interval_p99", setpoints.interval_p99},
          {"interval_max", setpoints.interval_max},
          {"jitter_p99", setpoints.jitter_p99}};
}

Json events_json(const FlightReport& report) {
  Json list = Json::array();
  for (const RecordedEvent& event : report.record.events) list.push_back({{"t", event.t}, {"what", event.what}});
  return list;
}

Json answers_json(const FlightReport& report) {
  Json list = Json::array();
  for (const FaultAnswer& answer : report.answers) {
    list.push_back({{"fault", answer.fault},
                    {"t", answer.at},
                    {"after", or_null(answer.after)},
                    {"what", answer.after ? Json(answer.what) : Json(nullptr)},
                    {"settled", or_null(answer.settled)}});
  }
  return list;
}

Json plans_json(const std::deque<FlownPlan>& plans) {
  Json list = Json::array();
  for (const FlownPlan& plan : plans) {
    const bool committed = plan.id > 0;
    list.push_back({{"id", committed ? Json(plan.id) : Json(nullptr)},
                    {"t", committed ? Json(plan.at) : Json(nullptr)},
                    {"status", describe(plan.plan.status)},
                    {"goal", to_json(plan.request.goal.position)},
                    {"moving", plan.request.start.velocity.norm() > 0},
                    {"duration", plan.segments.empty() ? Json(nullptr) : Json(total_duration(plan.segments))},
                    {"latency", committed ? Json(plan.latency) : Json(nullptr)},
                    {"total_us", plan.total_us}});
  }
  return list;
}

}  // namespace

Json plan_document(const MapFile& map, const FlownPlan& plan) {
  PlanTimes times;
  times.search = plan.search_us;
  if (plan.trajectory_us > 0) times.trajectory = plan.trajectory_us;
  times.total = plan.total_us;
  return plan_document(map, plan.request, plan.plan, times, {});
}

Json flight_document(const MapFile& map, const FlightRequest& request, const FlightReport& report,
                     const std::deque<FlownPlan>& plans, Json plan) {
  Json json{{"format", "swiftlet-flight/1"}, {"status", report.status}};
  if (!report.reason.empty()) json["reason"] = report.reason;
  json["state"] = describe(report.state);
  json["landed"] = report.landed;
  json["plan"] = std::move(plan);
  json["link"] = link_json(report);
  json["tracking"] = {{"rms", report.tracking_rms}, {"max", report.tracking_max}};
  json["flown_clearance"] = report.clearance;
  json["touched_at"] = report.touched_at ? Json(*report.touched_at) : Json(nullptr);
  json["flown_duration"] = report.duration;
  json["events"] = events_json(report);
  json["request"] = request_json(request);
  json["margins"] = margins_json(request, map);
  json["arrivals"] = report.arrivals;
  json["faults"] = answers_json(report);
  json["setpoints"] = setpoints_json(report.setpoints);
  json["reference"] = {{"max_speed", to_json(report.reference_speed)},
                       {"max_speed_norm", report.reference_speed_norm},
                       {"max_acceleration", to_json(report.reference_acceleration)},
                       {"max_acceleration_norm", report.reference_acceleration_norm}};
  json["estimate"] = {{"rms", report.estimate_rms}, {"max", report.estimate_max}};
  json["max_speed"] = report.speed_max;
  json["plans"] = plans_json(plans);
  json["simulated"] = report.simulated;
  if (!request.in_process) json["simulation_lag"] = report.lag_max;
  return json;
}

}  // namespace swiftlet::tools
