/* Particles that come and go, in an array of structs of your own: what is removed is closed up, in order, with your own fields.
 */
#include <dvdx/dvdx.h>
#include <stdint.h>
#include <stdio.h>

enum { capacity = 20000 };

struct drop {
  float position[3], velocity[3], age, lifetime;
  uint32_t number; /* 0 where the drop is new */
};

static struct drop drops[capacity];

static int fail(const char *what, const dvdx_error *error) {
  fprintf(stderr, "%s: %s\n", what, error->message);
  return 1;
}

static dvdx_column column_of(float *first) {
  const dvdx_column column = {.base = first, .stride = sizeof(struct drop), .run = 1, .capacity = capacity};
  return column;
}

static dvdx_status describe(dvdx_scene *scene, dvdx_error *error) {
  const dvdx_constant gravity = {.acceleration = {0, -9.81, 0}};
  const dvdx_drag air = {.coefficient = {.all = 0.3}, .wind = {1.5, 0, 0}};
  const dvdx_status status = dvdx_scene_add_constant(scene, &gravity, error);
  return status == DVDX_DONE ? dvdx_scene_add_drag(scene, &air, error) : status;
}

int main(void) {
  dvdx_error error;
  dvdx_scene *scene = NULL;
  dvdx_live_plan *plan = NULL;
  const dvdx_options options = {.step = 1.0 / 60, .precision = DVDX_FLOAT32};
  const dvdx_emitter nozzle = {.shape = DVDX_EMIT_DISC,
                               .at = {0, 1, 0},
                               .normal = {0, 1, 0},
                               .radius = 0.05,
                               .rate = 6000,
                               .velocity = {0, 9, 0},
                               .spread = 0.7,
                               .least_lifetime = 1.5,
                               .most_lifetime = 3,
                               .seed = 1};
  const dvdx_boundary ground = {.normal = {0, 1, 0}, .offset = 0};
  const dvdx_turnover turnover = {
      .emitters = &nozzle, .emitter_count = 1, .boundaries = &ground, .boundary_count = 1, .capacity = capacity};
  const dvdx_carried number = {.base = &drops[0].number, .stride = sizeof drops[0], .bytes = sizeof drops[0].number};
  dvdx_live live = {.state = dvdx_aos(DVDX_FLOAT32, drops[0].position, drops[0].velocity, sizeof drops[0], capacity),
                    .age = column_of(&drops[0].age),
                    .lifetime = column_of(&drops[0].lifetime),
                    .carried = &number,
                    .carried_count = 1};
  uint32_t last_number = 0;

  live.state.count = 0;
  if (dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) != DVDX_DONE) return fail("scene", &error);
  if (describe(scene, &error) != DVDX_DONE) return fail("forces", &error);
  if (dvdx_live_plan_create(scene, &turnover, &options, &plan, &error) != DVDX_DONE) return fail("plan", &error);
  dvdx_scene_destroy(scene);

  for (int frame = 0; frame < 240; ++frame) {
    if (dvdx_live_plan_step(plan, &live, 1, NULL, &error) != DVDX_DONE) return fail("step", &error);
    for (size_t i = live.state.count; i-- > 0 && drops[i].number == 0;) drops[i].number = ++last_number;
  }
  dvdx_live_plan_destroy(plan);

  printf("after %.2f s %zu of %llu drops are in the air; the oldest is number %u, %.2f s old, at y = %.2f m\n",
         live.state.clock.seconds, live.state.count, (unsigned long long)live.born, (unsigned)drops[0].number,
         (double)drops[0].age, (double)drops[0].position[1]);
  for (size_t i = 0; i < live.state.count; ++i) {
    if (drops[i].number == 0 || drops[i].position[1] < 0 || drops[i].age >= drops[i].lifetime) return 1;
  }
  return live.born == 24000 && live.born - live.removed == live.state.count && live.dropped == 0 && live.state.count > 5000 ? 0
                                                                                                                            : 1;
}
