/* cvol/cvol.h - all public headers of cvol. */
#ifndef CVOL_CVOL_H
#define CVOL_CVOL_H

#include "cvol/algebra.h"
#include "cvol/annotate.h"
#include "cvol/array.h"
#include "cvol/baked.h"
#include "cvol/base.h"
#include "cvol/camera.h"
#include "cvol/codec.h"
#include "cvol/engines.h"
#include "cvol/film.h"
#include "cvol/image.h"
#include "cvol/look.h"
#include "cvol/picture.h"
#include "cvol/render.h"
#include "cvol/series.h"
#include "cvol/transfer.h"
#include "cvol/volume.h"

#endif
