/* The same library from C99: particles in structs of your own, errors as texts in your own memory. */
#include <dvdx/dvdx.h>
#include <math.h>
#include <stdio.h>

enum { count = 1000 };

struct particle {
  float position[3];
  char name[5];
  float velocity[3];
};

static struct particle particles[count];

static int fail(const char *what, const dvdx_error *error) {
  fprintf(stderr, "%s: %s\n", what, error->message);
  return 1;
}

static dvdx_status describe(dvdx_scene *scene, dvdx_error *error) {
  const dvdx_constant gravity = {.acceleration = {0, -9.81, 0}};
  const dvdx_drag air = {.coefficient = {.all = 0.02}, .wind = {3, 0, 0}};
  const dvdx_plane floor = {.normal = {0, 1, 0}, .surface = {.restitution = 0.4}};
  dvdx_status status = dvdx_scene_add_constant(scene, &gravity, error);
  if (status == DVDX_DONE) status = dvdx_scene_add_drag(scene, &air, error);
  if (status == DVDX_DONE) status = dvdx_scene_add_plane(scene, &floor, error);
  return status;
}

int main(void) {
  dvdx_error error;
  dvdx_scene *scene = NULL;
  dvdx_plan *plan = NULL;
  const dvdx_options options = {.step = 1.0 / 60, .precision = DVDX_FLOAT32};
  dvdx_state state = dvdx_aos(DVDX_FLOAT32, particles[0].position, particles[0].velocity, sizeof particles[0], count);
  char text[4096];

  for (int i = 0; i < count; ++i) {
    particles[i].position[0] = 0.001F * (float)i;
    particles[i].position[1] = 1;
  }
  if (dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) != DVDX_DONE) return fail("scene", &error);
  if (describe(scene, &error) != DVDX_DONE) return fail("forces", &error);
  if (dvdx_plan_create(scene, &options, NULL, &plan, &error) != DVDX_DONE) return fail("plan", &error);
  dvdx_scene_destroy(scene);

  if (dvdx_plan_step(plan, &state, 60, NULL, &error) != DVDX_DONE) return fail("step", &error);
  dvdx_plan_explain(plan, text, sizeof text);
  printf("%s", text);
  printf("after %.2f s the last particle is at x = %.4f m\n", state.clock.seconds, (double)particles[count - 1].position[0]);

  if (dvdx_plan_set_step(plan, HUGE_VAL, &error) != DVDX_INVALID) return 1;
  printf("refused: %s\n", error.message);
  dvdx_plan_destroy(plan);
  return fabs(state.clock.seconds - 1) < 1e-12 && particles[0].position[0] > 0 ? 0 : 1;
}
