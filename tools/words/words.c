/* The words for values of enumerations. */
#include "words.h"

#include <stdio.h>
#include <string.h>

#include "cvol/cvol.h"

#define TABLE(name, ...)                                   \
    static const word_value name##_list[] = {__VA_ARGS__}; \
    const word_table name = {name##_list, sizeof name##_list / sizeof *name##_list}

TABLE(mode_words, {"composite", CVOL_MODE_COMPOSITE}, {"xray", CVOL_MODE_XRAY},
      {"mean", CVOL_MODE_XRAY}, {"mip", CVOL_MODE_MIP}, {"min", CVOL_MODE_MIN},
      {"iso", CVOL_MODE_ISO});
TABLE(engine_words, {"sheet", CVOL_ENGINE_SHEET}, {"ray", CVOL_ENGINE_RAY},
      {"splat", CVOL_ENGINE_SPLAT}, {"transform", CVOL_ENGINE_TRANSFORM},
      {"fourier", CVOL_ENGINE_FOURIER});
TABLE(transform_words, {"dct", CVOL_DCT}, {"dht", CVOL_DHT}, {"dft", CVOL_DFT});
TABLE(type_words, {"uint8", CVOL_UINT8}, {"int8", CVOL_INT8}, {"uint16", CVOL_UINT16},
      {"int16", CVOL_INT16}, {"uint32", CVOL_UINT32}, {"int32", CVOL_INT32},
      {"float32", CVOL_FLOAT32}, {"float64", CVOL_FLOAT64});
TABLE(plan_words, {"auto", CVOL_PLAN_AUTO}, {"direct", CVOL_PLAN_DIRECT}, {"grid", CVOL_PLAN_GRID},
      {"full", CVOL_PLAN_FULL}, {"sparse", CVOL_PLAN_SPARSE}, {"blocks", CVOL_PLAN_BLOCKS},
      {"low", CVOL_PLAN_LOW});
TABLE(footprint_words, {"gaussian", CVOL_FOOTPRINT_GAUSSIAN}, {"cone", CVOL_FOOTPRINT_CONE},
      {"sinc", CVOL_FOOTPRINT_SINC}, {"box", CVOL_FOOTPRINT_BOX});
TABLE(sheet_footprint_words, {"linear", CVOL_SHEET_LINEAR}, {"catmull-rom", CVOL_SHEET_CATMULL_ROM},
      {"b-spline", CVOL_SHEET_B_SPLINE}, {"gaussian", CVOL_SHEET_GAUSSIAN});
TABLE(ray_order_words, {"image", CVOL_RAY_ORDER_IMAGE}, {"object", CVOL_RAY_ORDER_OBJECT},
      {"auto", CVOL_RAY_ORDER_AUTO});
TABLE(order_words, {"front", CVOL_ORDER_FRONT}, {"back", CVOL_ORDER_BACK});
TABLE(plane_words, {"view", CVOL_FOOTPRINT_IN_VIEW}, {"slices", CVOL_FOOTPRINT_IN_SLICES});
TABLE(schedule_words, {"deferred", CVOL_SCHEDULE_DEFERRED}, {"literal", CVOL_SCHEDULE_LITERAL});
TABLE(axis_words, {"x", 0}, {"y", 1}, {"z", 2});
TABLE(effort_words, {"fast", CVOL_EFFORT_FAST}, {"default", CVOL_EFFORT_DEFAULT},
      {"max", CVOL_EFFORT_MAX});
TABLE(space_words, {"unknown", CVOL_SPACE_UNKNOWN}, {"LPS", CVOL_SPACE_LPS},
      {"RAS", CVOL_SPACE_RAS});

TABLE(labels_words, {"auto", LABELS_AUTO}, {"yes", LABELS_YES}, {"no", LABELS_NO});
TABLE(picture_background_words, {"black", PICTURE_BLACK}, {"white", PICTURE_WHITE},
      {"gradient", PICTURE_GRADIENT}, {"transparent", PICTURE_TRANSPARENT});
TABLE(light_words, {"studio", LIGHT_STUDIO}, {"cinematic", LIGHT_CINEMATIC},
      {"headlight", LIGHT_HEADLIGHT}, {"flat", LIGHT_FLAT});
TABLE(fit_words, {"object", FIT_OBJECT}, {"turn", FIT_TURN}, {"box", FIT_BOX});
TABLE(background_words, {"auto", CVOL_BACKGROUND_FIND}, {"none", CVOL_BACKGROUND_NONE});
TABLE(as_words, {"times", 0}, {"channels", 1});

int find_word(int *out, const word_table *table, const char *word)
{
    for (size_t i = 0; i < table->count; i++)
        if (!strcmp(word, table->words[i].word)) {
            *out = table->words[i].value;
            return 1;
        }
    return 0;
}

const char *word_of(const word_table *table, int value)
{
    for (size_t i = 0; i < table->count; i++)
        if (table->words[i].value == value)
            return table->words[i].word;
    return "?";
}

const char *list_words(char text[WORD_LIST], const word_table *table, const char *between,
                       const char *last)
{
    size_t length = 0;
    text[0] = '\0';
    for (size_t i = 0; i < table->count && length < WORD_LIST; i++)
        length += (size_t)snprintf(text + length, WORD_LIST - length, "%s%s",
                                   i == 0                 ? ""
                                   : i + 1 < table->count ? between
                                                          : last,
                                   table->words[i].word);
    return text;
}
