/* What jansson's own build writes, for systems of today. */
#define HAVE_STDINT_H 1
#define INITIAL_HASHTABLE_ORDER 3
