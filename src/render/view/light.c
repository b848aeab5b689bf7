/* Light of a frame (light.h). */
#include "render/view/light.h"

#include <math.h>
#include <string.h>

#include "base/context.h"

void cvol_light_set(cvol_light *light, const cvol_view *view, const cvol_grid *grid,
                    const cvol_shading *shading, const int axes[3], const int turns[3])
{
    const double *given = shading->light;
    const double length = hypot(hypot(given[0], given[1]), given[2]);
    double facing = 0;
    memset(light, 0, sizeof *light); /* lights are compared by their bytes */
    light->on = shading->on;
    if (!shading->on)
        return;
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        const double towards = length > 0 ? given[a] / length : view->eye[a];
        light->eye[k] = (float)(turns[k] * view->eye[a]);
        light->light[k] = (float)(turns[k] * towards);
        light->rise[k] = (float)(0.5 * view->mean_spacing / grid->spacing[a]);
        facing += view->eye[a] * towards;
    }
    light->facing_light = (float)facing;
    light->ambient = (float)shading->ambient;
    light->diffuse = (float)shading->diffuse;
    light->specular = (float)shading->specular;
    light->shininess = shading->shininess;
    light->thinning = shading->gradient_opacity > 0 ? (float)(1 / shading->gradient_opacity) : 0;
}
