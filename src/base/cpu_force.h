/* Forces an instruction set, for tests that compare sets in one process. */
#ifndef CVOL_BASE_CPU_FORCE_H
#define CVOL_BASE_CPU_FORCE_H

/* From now on cvol_cpu_best returns `cpu`, a cvol_cpu that the processor has. Not while another
 * thread draws. */
void cvol_cpu_force(int cpu);

#endif
