/* Data types of ANARI. */
#ifndef CVOL_ANARI_TYPES_H
#define CVOL_ANARI_TYPES_H

#include <anari/anari.h>

#include <cstddef>

namespace cvol_anari
{

/* Bytes of a value or of an element; 0 for a type that neither parameters nor arrays have. */
size_t size_of(ANARIDataType type);
/* "camera", "spatial field", ..., for messages. */
const char *type_name(ANARIDataType type);
/* 1 for handles of objects. */
bool is_object(ANARIDataType type);

} // namespace cvol_anari
#endif
