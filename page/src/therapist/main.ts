import { mount } from "svelte";
import { chair } from "../chair.svelte";
import { link } from "../link";
import { heedLinks } from "../server";
import "../theme.css";
import "./therapist.css";
import { applyTheme } from "../theme";
import Therapist from "./Therapist.svelte";

applyTheme();
heedLinks(window);
chair.follow(link);
mount(Therapist, { target: document.querySelector("#page")! });
