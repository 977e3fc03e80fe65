"""Tests that run with --slow only: what they test at length is tested more quickly beside them.

They are variants of a test of which a quicker one runs always, or runs that combine terms with tests of their own. Each
of them compiles kernels of its own for 10 to 150 s; the suite of every change stays short without them.
"""

SLOW_VARIANTS = {
    "test_bar_impact": {
        "test_160_hexes_against_the_exact_solution[0.0-full-1]",
        "test_massless_penalty_keeps_the_step_and_tends_to_the_exact_constraint[tet4-full-2]",
    },
    "test_bench": {
        "test_every_element_is_measured_against_its_own_reference_and_plain_kernel[hex8-reduced-linear-1]",
        "test_every_element_is_measured_against_its_own_reference_and_plain_kernel[tet4-ogden-6]",
    },
    "test_bench_contact": {
        "test_friction_rows_carry_errors_and_slide",
    },
    "test_bodies_together": {
        "test_two_bodies_on_a_wall_do_what_each_does_alone[hexes and tets]",
        "test_two_bodies_that_mprgp_solves_do_what_each_does_alone",
        "test_with_friction_and_on_the_path_of_large_bodies_too",
    },
    "test_cell_blocks": {
        "test_a_formulation_goes_to_the_kinds_that_have_it[reduced]",
        "test_every_term_keeps_momentum_and_energy[friction on masses]",
        "test_every_term_keeps_momentum_and_energy[layers]",
        "test_every_term_keeps_momentum_and_energy[viscosity and damping]",
        "test_force_mass_and_stress_are_those_of_the_cells_one_by_one[corner-stiff]",
        "test_impact_on_contact_cells_of_two_kinds_and_materials_keeps_the_ledger[beside-falling-4-normal]",
        "test_impact_on_contact_cells_of_two_kinds_and_materials_keeps_the_ledger[corner-falling-4-full]",
        "test_impact_on_contact_cells_of_two_kinds_and_materials_keeps_the_ledger[corner-falling-4-normal]",
        "test_the_serial_and_the_parallel_path_agree",
    },
    "test_cell_viscosity": {
        "test_absent_it_leaves_nothing_behind[full removal]",
        "test_one_kernel_two_kernels_and_many_steps_a_launch_give_the_same[neo-tet4-full]",
        "test_the_stable_step_is_that_of_the_damped_body[tet4-1.0]",
    },
    "test_central_difference": {
        "test_every_row_equals_the_oracle[tet4-linear-1-normal-None-supports6]",
        "test_every_row_equals_the_oracle[wedge6-neo-2-full-None-supports9]",
        "test_the_contact_force_converges_with_the_square_of_the_step[wedge6-full]",
    },
    "test_cube_impact": {
        "test_normal_and_full_removal_rebound_alike[tet4-NeoHookean-8-0.005]",
    },
    "test_cuda": {
        "test_stable_steps_are_those_of_the_cpu[forged]",
    },
    "test_damping": {
        "test_a_rigid_body_decays_exponentially_to_second_order[full]",
        "test_an_impact_with_damping_keeps_the_ledger[tet4-contact1]",
        "test_momentum_with_supports_and_every_contact_model[massless]",
    },
    "test_engines": {
        "test_the_fork_gives_the_same_bits[names0]",
    },
    "test_free_obstacles": {
        "test_momentum_and_energy_at_any_ratio_of_masses[0.001]",
        "test_one_thread_and_two_give_the_same_bits",
    },
    "test_friction": {
        "test_a_belt_takes_a_block_to_its_speed[full]",
        "test_every_row_equals_the_oracle[penalty, corner]",
        "test_pressure_shear_slab_meets_its_checks_in_both_regimes[full]",
    },
    "test_friction_contact_layer": {
        "test_a_layer_that_has_left_the_wall_holds_its_share_of_the_work[full-0.01]",
        "test_a_mass_brought_to_rest_has_turned_into_friction_work_and_heat[full]",
        "test_a_mass_brought_to_rest_has_turned_into_friction_work_and_heat[normal]",
    },
    "test_friction_fields": {
        "test_the_work_of_all_nodes_is_that_of_the_ledger[pair and floor, normal]",
    },
    "test_friction_laws": {
        "test_a_belt_that_speeds_up_takes_a_block_along_below_static_friction[normal]",
        "test_a_resumed_run_of_a_pair_with_a_law_has_the_same_bits",
        "test_a_sliding_block_slows_down_by_its_law[constant-full]",
        "test_a_sliding_block_slows_down_by_its_law[falling-full]",
        "test_a_sliding_block_slows_down_by_its_law[falling-normal]",
        "test_a_sliding_block_slows_down_by_its_law[table-full]",
        "test_every_obstacle_at_a_node_has_its_own_friction[full]",
        "test_large_bodies_slow_down_by_the_law[normal]",
        "test_pairs_and_obstacles_have_their_own_laws[full]",
        "test_pairs_and_obstacles_have_their_own_laws[normal]",
        "test_static_friction_is_the_threshold_of_sliding[full]",
        "test_two_floors_stop_two_blocks_each_by_its_own_friction[normal]",
    },
    "test_implicit_blocks": {
        "test_an_impact_is_that_of_the_explicit_scheme[full]",
    },
    "test_implicit_cases": {
        "test_a_cube_that_is_meant_to_lose_energy_passes_where_it_gains_none[scheme=dissipative chi=0.3]",
    },
    "test_initial_layers": {
        "test_scenes_without_layers_leave_none",
        "test_the_start_of_another_scene_may_differ_and_new_nodes_begin_cold",
    },
    "test_inverted_cells": {
        "test_the_remedy_ends_in_a_finished_run[hex8]",
    },
    "test_law_state": {
        "test_only_the_step_pass_commits[hex8-full-2-serial]",
        "test_only_the_step_pass_commits[hex8-reduced-3-serial]",
        "test_only_the_step_pass_commits[tet4-full-2-serial]",
        "test_only_the_step_pass_commits[wedge6-full-2-serial]",
    },
    "test_layers_heat_bodies": {
        "test_only_bodies_of_metal_take_heat",
        "test_points_whose_heat_has_a_pressure_keep_the_heat_of_the_layers",
        "test_the_far_end_has_the_temperature_of_the_cells",
    },
    "test_layers_two_sides": {
        "test_a_layer_between_bodies_is_the_layer_alone",
        "test_equal_blocks_share_the_heat_equally[full-contact1]",
        "test_layers_of_several_kinds_close_the_ledger_and_go_on[normal]",
        "test_two_metals_share_the_heat_by_their_effusivities[full]",
    },
    "test_load_cases": {
        "test_the_checks_of_the_cases_hold[tcontact.cases.inflated_ring-12]",
    },
    "test_maxima": {
        "test_every_frame_has_the_same_maxima[mean dilatation]",
        "test_every_frame_has_the_same_maxima[metal]",
        "test_every_frame_has_the_same_maxima[node-averaged]",
        "test_every_frame_has_the_same_maxima[serial]",
        "test_every_frame_has_the_same_maxima[two bodies, two materials]",
    },
    "test_mean_dilatation_runs": {
        "test_a_nearly_incompressible_impact_is_softer_than_locking_hexes_make_it",
        "test_balance_in_mid_contact[linear-normal-1]",
        "test_cube_impact_meets_its_checks[{'poisson': 0.45, 'pitch': 10.0, 'yaw': 20.0}]",
        "test_cube_impact_meets_its_checks[{'poisson': 0.499, 'law': 'mooney-rivlin'}]",
        "test_cube_impact_meets_its_checks[{'poisson': 0.499, 'removal': 'full'}]",
        "test_static_solve_meets_its_residual_with_an_exact_tangent[full]",
    },
    "test_metal_cases": {
        "test_elastic_plates_slide_and_stick_as_plane_waves_do[0.1]",
        "test_every_joule_stands_in_layers_blocks_and_cold_work",
    },
    "test_metal_contact": {
        "test_contact_tangent_is_the_slope_of_the_force_from_the_committed_state[hex8-reduced-hardening4-full-0.002]",
        "test_impact_on_two_planes_and_on_a_ball_converges_and_keeps_its_energy",
    },
    "test_metals": {
        "test_a_run_goes_on_with_a_metal_beside_a_rubber",
        "test_resume_has_the_same_bits[reduced]",
        "test_the_rate_of_a_run_is_that_of_its_steps",
    },
    "test_mixed_mesh": {
        "test_a_scene_file_keeps_kinds_cell_sets_and_materials[mixed]",
        "test_a_stopped_run_goes_on_with_the_same_bits",
    },
    "test_mixed_precision": {
        "test_a_translation_of_a_million_lengths_changes_no_bit[hex8-reduced]",
        "test_bulk_viscosity_in_float32_has_the_force_and_power_of_float64[1e-09-wedge6]",
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-0.0]",
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-mean-dilatation-0.0]",
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-reduced-0.0]",
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-reduced-0.2]",
        "test_plastic_flow_in_float32_dissipates_and_hardens_as_in_float64[hex8-reduced]",
    },
    "test_mixed_runs": {
        "test_a_drop_has_the_force_and_impulse_of_float64[contact0-parallel]",
        "test_a_drop_has_the_force_and_impulse_of_float64[contact1-one launch]",
        "test_the_bench_measures_mixed_precision_beside_its_errors",
    },
    "test_momentum": {
        "test_free_fall_strains_nothing[full-linear-tet4]",
        "test_free_fall_strains_nothing[full-svk-hex8]",
        "test_free_fall_strains_nothing[normal-linear-hex8]",
        "test_free_fall_strains_nothing[normal-neo-tet4]",
    },
    "test_mooney_rivlin": {
        "test_same_equilibrium_as_the_oracle[hex8-full]",
        "test_same_equilibrium_as_the_oracle[tet4-normal]",
        "test_without_c2_it_is_neo_hookean_and_it_is_objective[tet4]",
    },
    "test_moving_wall": {
        "test_only_the_relative_velocity_counts[full]",
        "test_only_the_relative_velocity_counts[impulse-coulomb]",
        "test_only_the_relative_velocity_counts[normal-coulomb]",
        "test_only_the_relative_velocity_counts[penalty-coulomb]",
    },
    "test_mprgp": {
        "test_an_impact_is_the_same_with_both_solvers[hex8-linear-full]",
        "test_the_bench_compares_both_solvers",
    },
    "test_multi_body": {
        "test_a_file_with_both_kinds_gives_a_body_of_each",
    },
    "test_named_warnings": {
        "test_a_slave_much_stiffer_than_its_master_is_named",
        "test_cells_that_lock_are_named[hex8-reduced-0.49-False-neo]",
    },
    "test_node_averaged_runs": {
        "test_a_copper_bar_spreads_as_it_should[3-21.555-7.445-strain0-0.003-0.5]",
        "test_impacts_keep_the_ledger_on_both_paths[normal removal]",
        "test_resume_has_the_same_bits",
    },
    "test_ogden": {
        "test_contact_stiffness_is_the_slope_of_the_force[hex8-reduced-normal]",
        "test_cube_impact[options0]",
        "test_equibiaxial_stretch[0.6-hex8-reduced]",
        "test_equibiaxial_tension[wedge6]",
    },
    "test_pair_cases": {
        "test_a_ball_falls_on_a_plate_out_of_a_file",
        "test_balls_that_do_not_follow_hertz_fail",
        "test_two_balls_follow_hertz",
    },
    "test_pair_evidence": {
        "test_a_block_slides_over_the_edges_of_the_faces_of_its_partner[up-hex8]",
        "test_the_order_of_bodies_sets_and_faces_changes_nothing",
    },
    "test_pair_files": {
        "test_a_body_and_a_wall_press_the_same_nodes_from_two_sides",
        "test_a_node_that_is_squeezed_between_a_body_and_an_obstacle_stops_the_run_by_name[low]",
        "test_a_resumed_run_has_the_same_bits[parallel]",
        "test_a_resumed_run_keeps_the_gaps_that_count_as_closed",
        "test_a_slave_too_coarse_for_the_curvature_of_its_master_is_told[low]",
        "test_a_slave_too_coarse_for_the_curvature_of_its_master_is_told[up]",
    },
    "test_pair_friction": {
        "test_a_block_holds_on_a_held_incline_without_creep[full]",
        "test_a_block_slides_to_rest_on_a_free_block[parameters1]",
        "test_a_block_slides_to_rest_on_a_free_block[parameters3]",
        "test_oblique_impact_with_friction_conserves_and_turns_with_its_axes",
        "test_the_solver_of_pairs_agrees_with_the_sweeps",
    },
    "test_pair_obstacles": {
        "test_a_resumed_run_in_a_corner_has_the_same_bits",
        "test_a_turned_corner_is_the_same_corner",
        "test_an_impact_into_a_corner_keeps_the_momentum_ledger_and_the_energy",
        "test_curved_and_moving_obstacles_carry_a_pair",
        "test_several_rows_at_slaves_and_masters_are_solved_as_densely[1.0-0.5]",
    },
    "test_pair_runs": {
        "test_a_body_of_flat_cells_is_met_where_it_lies",
        "test_a_body_whose_contact_face_is_held_is_master",
        "test_a_moving_wall_under_a_pair_has_its_own_load_and_work",
        "test_a_stack_on_a_floor_settles_with_its_weight_on_the_floor_and_between_the_blocks",
        "test_bodies_of_two_kinds_of_cells_and_two_materials_touch",
        "test_damping_and_viscosity_keep_the_balance",
        "test_facets_of_fitting_rings_touch_all_around_if_their_gaps_count_as_closed",
        "test_formulations_of_hexahedra[mean-dilatation]",
        "test_formulations_of_hexahedra[reduced]",
        "test_gaps_of_facets_count_as_closed_whatever_the_shape_of_the_faces[tet4-0.2]",
        "test_oblique_cubes_keep_energy_and_momentum[tet4]",
        "test_oblique_cubes_keep_energy_and_momentum[wedge6]",
    },
    "test_pair_statics": {
        "test_three_bodies_above_a_plane_are_solved_as_by_a_dense_active_set[chain-hex8]",
        "test_three_bodies_above_a_plane_are_solved_as_by_a_dense_active_set[shoulder-hex8]",
    },
    "test_periodic": {
        "test_a_column_hits_the_floor_like_a_bar_without_lateral_strain[hex8-full-full]",
        "test_a_column_hits_the_floor_like_a_bar_without_lateral_strain[hex8-full-reduced]",
        "test_a_column_hits_the_floor_like_a_bar_without_lateral_strain[tet4-normal-full]",
        "test_one_period_is_what_many_periods_are[friction layers, moving wall]",
        "test_one_period_is_what_many_periods_are[full removal, friction]",
        "test_one_period_is_what_many_periods_are[full removal, own force, gravity in time]",
        "test_one_period_is_what_many_periods_are[full removal, tets, damping]",
        "test_one_period_is_what_many_periods_are[impulse]",
        "test_one_period_is_what_many_periods_are[normal removal, loads]",
        "test_one_period_is_what_many_periods_are[one-point hexes, gravity]",
        "test_one_period_is_what_many_periods_are[penalty, supports, viscosity]",
        "test_one_period_is_what_many_periods_are[prisms, full removal]",
        "test_pressure_shear_impact_sticks_or_slides_as_the_waves_say[0.5-0.5-full]",
    },
    "test_plate_impact": {
        "test_copper_meets_its_shock_curve[1500.0]",
        "test_copper_meets_its_shock_curve[200.0]",
        "test_heat_of_the_viscosity_warms_the_cells",
        "test_resume_has_the_same_bits",
    },
    "test_probes": {
        "test_a_split_run_has_the_same_bits[central-difference]",
    },
    "test_rank_ends": {
        "test_a_run_on_two_ranks_goes_on_with_the_bits_of_one_that_never_stopped[killed-walls]",
    },
    "test_ranks": {
        "test_the_bench_measures_two_ranks_beside_one",
    },
    "test_reduced": {
        "test_force_and_energy_match_numpy_and_each_other[neo]",
    },
    "test_reduced_runs": {
        "test_an_impact_turned_in_space_is_the_same_impact",
        "test_balance_in_mid_contact[linear-normal-1]",
        "test_balance_in_mid_contact[neo-full-2]",
        "test_bar_impact_with_one_point_hexes",
        "test_cube_impact_with_one_point_hexes[full]",
        "test_one_and_two_threads_give_the_same_bits",
    },
    "test_reduced_stiffness": {
        "test_contact_stiffness_is_the_slope_of_the_force_and_positive_definite[full-mooney]",
    },
    "test_resume": {
        "test_a_split_run_has_the_same_bits[friction layers on masses]",
        "test_a_split_run_has_the_same_bits[moving wall, damping, viscosity, two bodies]",
        "test_resumed_on_another_number_of_threads",
        "test_the_command_line_goes_on_where_ctrl_c_stopped[scene file]",
    },
    "test_rigid_parts": {
        "test_friction_pulls_a_light_plate_along_without_a_jerk[normal]",
    },
    "test_rolling": {
        "test_a_cylinder_that_slides_ends_in_rolling",
    },
    "test_set_up": {
        "test_nearest_points_are_those_of_all_triangles[300-1.0]",
        "test_nearest_points_are_those_of_all_triangles[300-1000000.0]",
        "test_nearest_points_are_those_of_all_triangles[300-1e-06]",
    },
    "test_shape_bound": {
        "test_rates_are_those_of_the_worst_cells[tet4-viscosity1]",
        "test_rates_are_those_of_the_worst_cells[wedge6-None]",
    },
    "test_shared_domain": {
        "test_a_body_with_all_contact_nodes_held_does_not_choose_the_solver_of_others",
        "test_projected_gradients_leave_alone_a_body_that_is_held_while_another_slides",
    },
    "test_small_bodies": {
        "test_rows_and_end_state_are_the_same[full removal, two walls, tets]",
    },
    "test_smoothness": {
        "test_the_pressures_of_every_row_are_those_of_the_history[impulse-serial]",
    },
    "test_springs": {
        "test_a_driven_pair_on_springs_keeps_its_momentum_balance",
        "test_springs_in_a_run_with_contact_resume_with_the_same_bits",
    },
    "test_stability": {
        "test_hard_case[jittered-tets]",
        "test_hard_case[tets-all-in-contact-set]",
    },
    "test_static_solve": {
        "test_balance_in_mid_contact[hex8-full-2-linear]",
        "test_cold_sweeps_do_not_grow_with_the_mesh[tet4-50-sizes1]",
        "test_same_equilibrium_as_the_oracle[hex8-linear-full-3-None]",
        "test_same_equilibrium_as_the_oracle[hex8-neo-full-2-1000.0]",
        "test_same_equilibrium_as_the_oracle[tet4-svk-full-1-40.0]",
        "test_same_equilibrium_as_the_oracle[wedge6-neo-full-2-None]",
    },
    "test_supports": {
        "test_prescribed_components_move_as_told_and_the_others_are_free[full-tet4]",
        "test_prescribed_components_move_as_told_and_the_others_are_free[normal-hex8]",
        "test_prescribed_components_move_as_told_and_the_others_are_free[normal-tet4]",
    },
    "test_tracing": {
        "test_no_function_of_the_package_changes_an_argument_that_it_passes_on",
    },
    "test_two_materials": {
        "test_a_contact_face_of_two_materials_bears_the_exact_pressure_of_each[0-shift0-full]",
    },
    "test_viscosity": {
        "test_force_and_power_of_one_short_step[hex8-reduced]",
        "test_momentum_in_an_impact[hex8-full-2]",
        "test_momentum_in_an_impact[tet4-normal-1]",
    },
    "test_walls": {
        "test_a_floor_named_several_times_rubs_as_one[2]",
        "test_a_floor_named_several_times_rubs_as_one[3]",
        "test_a_shaken_bar_between_touching_walls_stays_between_them[0-full]",
        "test_a_wall_out_of_reach_changes_not_a_bit[friction]",
        "test_a_wall_out_of_reach_changes_not_a_bit[normal removal, across]",
        "test_a_wall_out_of_reach_changes_not_a_bit[normal removal, parallel]",
    },
}
